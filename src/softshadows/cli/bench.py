"""`softshadows bench`: run a suite, render committed results as a page, compare two results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from softshadows.cli.parts import SizeOption, check_folder, new_console, say

GOT_WORSE = 1
RUN = "run"


class SuitesAndCommands(TyperGroup):
    """`bench baselines` is `bench run baselines`: what is no command is a suite."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        known = {*self.commands, *ctx.help_option_names}
        return super().parse_args(ctx, args if not args or args[0] in known else [RUN, *args])


bench = typer.Typer(
    cls=SuitesAndCommands,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    subcommand_metavar="SUITE | COMMAND [ARGS]...",
    help="""Run a benchmark suite, make the benchmark page, compare two results.

    softshadows bench baselines --json baselines.json

    softshadows bench compare before.json after.json

    softshadows bench report

`softshadows bench run -h` lists the suites and what a run may change.
""",
)


@bench.command(RUN)
def run(
    suite: Annotated[
        str, typer.Argument(metavar="SUITE", help="A suite's name, such as `baselines`.", show_default=False)
    ],
    json: Annotated[
        Path | None,
        typer.Option(
            "--json",
            help="Also write all figures to this file; pictures, if the suite makes any, to a folder of its name.",
            show_default=False,
        ),
    ] = None,
    size: SizeOption = None,
    samples: Annotated[
        int, typer.Option("--samples", min=1, max=65536, help="Rays per pixel and light for the truth.")
    ] = 256,
    repeats: Annotated[int, typer.Option("--repeats", min=1, max=1000, help="Timed frames of each technique.")] = 5,
) -> None:
    """Run a suite: every figure beside the truth, medians over frames rendered interleaved.

    `softshadows bench baselines --json baselines.json`

    Suites: adaptive, baselines, bitmask, choice, linear, mobile, rays, scaling, wedges.

    The real scenes are measured too where SOFTSHADOWS_SCENES names their folder.
    """
    console = new_console()
    if json is not None:
        check_folder(json.parent)
    with console.status("preparing the device"):
        from softshadows.bench.suites import Settings, find_suite
        from softshadows.compare.console import figures_table, progress, results_table
        from softshadows.compare.results import results, write_json
        from softshadows.scene.description import size_from_text

        measure = find_suite(suite)
        folder = json.with_suffix("") if json is not None and json.suffix else None
        if folder is not None:
            check_folder(folder, may_be_new=True)
        settings = Settings(size_from_text(size) if size else None, samples, repeats, folder)
    with progress(console) as notice:
        measurements = measure(settings, notice)
        data = results(measurements, suite=suite)
    if json is not None:
        write_json(data, json)
    console.print(results_table(measurements))
    for table in filter(None, map(figures_table, measurements)):
        console.print(table)
    say(console, [f"{m.shot.name}: {sentence}" for m in measurements for sentence in m.skipped])
    machine = data["environment"]
    adapter = machine["adapter"]
    console.print(
        f"{adapter['adapter']} ({adapter['backend']}, {adapter['driver']}), {machine['cpu']}, "
        f"commit {machine['commit']}",
        highlight=False,
        soft_wrap=True,
    )


@bench.command()
def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help="JSON of a suite.", show_default=False)],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="JSON of the same suite, later.", show_default=False)],
) -> None:
    """Print what got slower, worse or larger beyond noise; exit code 1 if something did.

    `softshadows bench compare before.json after.json`

    A time changed where each median lies outside the other's spread, fastest to slowest, and they are more than 5 %
    apart; an error where it moved by more than 2 % and by more than rounding does.
    """
    from softshadows.bench.changes import changes
    from softshadows.bench.console import changes_table
    from softshadows.compare.schema import read_results

    console = new_console()
    found = changes(read_results(before), read_results(after))
    say(console, found.notes)
    for title, listed in (("better", found.better), ("worse", found.worse)):
        if listed:
            console.print(changes_table(title, listed))
    for sentence in found.gone:
        console.print(sentence, highlight=False, soft_wrap=True)
    worse = len(found.worse) + len(found.gone)
    console.print(
        f"{found.compared} figures compared: {worse or 'nothing'} got worse, {len(found.better) or 'nothing'} better",
        highlight=False,
        soft_wrap=True,
    )
    if found.got_worse:
        raise typer.Exit(GOT_WORSE)


@bench.command()
def report(
    results: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="JSON...",
            help="Files of suites; left out: those in benchmarks/results, suite by suite.",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="The page; its charts go to images/benchmarks beside it.")
    ] = Path("docs/benchmarks.md"),
) -> None:
    """Render results of suites as a Markdown page with charts.

    `softshadows bench report`

    `softshadows bench report linear.json wedges.json -o report/benchmarks.md`
    """
    from softshadows.bench.benchmarks import IMAGES, benchmarks_page, committed_results
    from softshadows.compare.results import write_bytes
    from softshadows.compare.schema import read_results

    page, charts = benchmarks_page([read_results(path) for path in results or committed_results(Path())])
    for name, text in charts.items():
        write_bytes(text.encode(), output.parent / IMAGES / name)
    write_bytes(page.encode(), output)
    new_console().print(f"{output} and {len(charts)} charts", highlight=False, soft_wrap=True)
