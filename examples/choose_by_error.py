"""The fastest technique that is good enough for your view.

Measures every technique that can do the light, on the view that counts, and keeps the fastest below a bound.
"""

import time

import softshadows as ss

BOUND = 0.03


def main(size: tuple[int, int] = (512, 384), samples: int = 256) -> None:
    scene = ss.scenes.fence()
    assert scene.camera is not None
    lights = scene.lights
    found = []
    for name, technique in ss.techniques.TECHNIQUES.items():
        if any(light.kind not in technique.light_kinds for light in scene.lights):
            continue
        with ss.Renderer(scene, technique=name, size=size) as renderer:
            scene.lights = [light.moved((0.01, 0.0, 0.0)) for light in lights]
            renderer.render(scene.camera)  # compiles and uploads
            scene.lights = lights  # moved, so that no technique is measured with shadow maps that it has cached
            started = time.perf_counter()
            frame = renderer.render(scene.camera)
            seconds = time.perf_counter() - started
        truth = ss.truth.visibility(scene, frame, samples=samples)[0]
        rmse = ss.metrics.compare(frame.visibility[0], truth, frame.surface & frame.facing[0]).rmse
        print(f"{name:20} rmse {rmse:.4f}   {seconds:6.2f} s")
        found.append((seconds, rmse, name, frame))
    good = [one for one in found if one[1] <= BOUND] or [min(found, key=lambda one: one[1])]
    _, rmse, name, frame = min(good, key=lambda one: one[0])
    print(f"{name}, rmse {rmse:.4f}")
    frame.save("choose_by_error.png")


if __name__ == "__main__":
    main()
