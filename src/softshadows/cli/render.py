"""`softshadows render`: one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from softshadows.cli.parts import (
    CameraOption,
    GroundOption,
    LightOption,
    OnMissing,
    OnMissingOption,
    OptionsOption,
    Profile,
    ProfileOption,
    SceneArgument,
    SizeOption,
    check_folder,
    new_console,
    open_view,
    say,
)
from softshadows.errors import OptionError

PICTURES = (".png", ".exr", ".npz")


def render(
    scene: SceneArgument,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Picture: .png (displayed), .exr or .npz (linear, every image by name)."),
    ],
    technique: Annotated[
        str | None,
        typer.Option("-t", "--technique", metavar="NAME", help="How to compute the shadows.", show_default=False),
    ] = None,
    options: OptionsOption = None,
    light: LightOption = None,
    camera: CameraOption = None,
    size: SizeOption = None,
    ground: GroundOption = False,
    on_missing: OnMissingOption = OnMissing.error,
    profile: ProfileOption = Profile.full,
) -> None:
    """Render a picture.

    `softshadows render figures -o figures.png`

    `softshadows render chair.glb --ground -t uniform -O grid=9 --size 800x600 -o chair.exr`

    `softshadows render chair.glb --camera position=3,2,4:target=0,1,0:fov=45 -o chair.png`

    `softshadows render chair.glb --light line:start=-1,2,0:end=1,2,0:radiance=30,30,30 -o chair.png`

    `--light rect:position=0,4,0:target=0,0,0:width=1:height=1:radiance=10,10,10`
    """
    console = new_console()
    if output.suffix.lower() not in PICTURES:
        raise OptionError(f"--output must end in one of {', '.join(PICTURES)}, got {str(output)!r}")
    check_folder(output.parent)
    with console.status("reading the scene"):
        shot = open_view(scene, light, camera, size, ground, on_missing)
    with console.status("preparing the device"):
        from softshadows.compare.choice import technique_from
        from softshadows.renderer import Renderer

        chosen = technique_from(shot, technique, options or [])
        renderer = Renderer(shot.scene, technique=chosen, size=shot.size, profile=profile.value)
    with console.status(f"rendering with {renderer.technique.name}"), renderer:
        frame = renderer.render(shot.camera)
        _save(frame, output)
    say(console, [*shot.notes, *(w for w in frame.stats.warnings if w not in shot.notes)])
    milliseconds = sum(frame.stats.gpu_ms.values())
    timing = f", {milliseconds:.1f} ms on the GPU" if milliseconds else ""
    console.print(
        f"{output}: {shot.size[0]}×{shot.size[1]}, technique {renderer.technique.name}, "
        f"{frame.stats.shadow_maps} shadow {'map' if frame.stats.shadow_maps == 1 else 'maps'}{timing}",
        highlight=False,
        soft_wrap=True,
    )


def _save(frame: Any, output: Path) -> None:
    try:
        frame.save(output)
    except OSError as error:
        raise OptionError(f"{output} cannot be written: {error.strerror or error}") from error
