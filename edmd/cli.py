"""The command line. Everything heavy is imported by the command that needs it: `edmd --help` answers at once."""

import argparse
import os
import sys
import time

import edmd

PICTURES = (".png", ".jpg", ".tif", ".pdf")
JAMMED = 1e8                    # reduced pressure that counts as jammed, unless a run says another
CONTACT_GAP = ("relative gap below which two bodies are in contact (default, as for `edmd pack`: 1000 over the reduced pressure at which "
               "the run ends, at most 0.01; for other runs 1e-5)")
BAD_INPUT, FAILED, INTERRUPTED = 2, 1, 130


def main(arguments=None):
    """Run a command; -> its exit status: 0 done, 1 a check failed, 2 bad input, 130 interrupted."""
    options = _parser().parse_args(arguments)
    try:
        status = options.command(options)
        sys.stdout.flush()
        return status
    except ValueError as problem:
        print(f"edmd {options.name}: {problem}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:                     # who reads, such as `head`, has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (OSError, RuntimeError) as problem:
        print(f"edmd {options.name}: {_with_its_file(problem, getattr(options, 'output', None))}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt as interrupt:
        writes_frames = options.name in ("pack", "run", "resume")
        kept = str(interrupt) or ("frames already written are kept" if writes_frames else "nothing was written")
        print(f"edmd {options.name}: interrupted; {kept}", file=sys.stderr)
        return INTERRUPTED


def _with_its_file(problem, output):
    """A problem in words; a full disk does not say itself which file it had no room for."""
    if isinstance(problem, OSError) and problem.strerror and problem.filename is None and output:
        return f"output = {output!r}: {problem.strerror}"
    return str(problem)


class _Help(argparse.ArgumentDefaultsHelpFormatter):
    """Shows defaults, but not those that the help itself explains."""

    def _get_help_string(self, action):
        return action.help if action.default is None or action.default is False else super()._get_help_string(action)


def _parser():
    parser = argparse.ArgumentParser(prog="edmd", description="Event-driven dynamics and jammed packings of hard ellipsoids.")
    parser.add_argument("--version", action="version", version=f"edmd {edmd.__version__}")
    commands = parser.add_subparsers(title="commands", dest="name", required=True, metavar="COMMAND")

    def command(name, run, description):
        added = commands.add_parser(name, help=description, description=description, formatter_class=_Help)
        added.set_defaults(command=run)
        return added

    pack = command("pack", _pack, "compress a fluid of ellipsoids until it jams, and write the whole course to a file")
    pack.add_argument("-n", type=int, default=256, help="number of bodies")
    pack.add_argument("--semi-axes", type=float, nargs=3, default=[1.25, 1.0, 0.8], metavar=("A", "B", "C"), help="semi-axes at the start")
    pack.add_argument("--rate", type=float, default=1e-3, help="growth of the semi-axes, as 1 + rate t at kT = 1 and mass 1, from a "
                      "reduced pressure of 100 on")
    pack.add_argument("--fluid-rate", type=float, default=None,
                      help="growth before that (default: 0.01 / (abc)^(1/3), or the rate if that is faster)")
    pack.add_argument("--seed", type=int, default=0, help="seed of the thermal velocities")
    pack.add_argument("--until-pressure", type=float, default=JAMMED, help="reduced pressure P V / (n kT) that counts as jammed")
    pack.add_argument("--start-fraction", type=float, default=None, help="packing fraction of the crystal that melts (default: 0.3, or "
                      "less for shapes that do not fit)")
    pack.add_argument("--melt", type=float, default=100.0, help="collisions per particle before the compression")
    pack.add_argument("-o", "--output", default="packing.h5md", help="H5MD file to write")
    pack.add_argument("--overwrite", action="store_true", help="replace the output when it exists")
    pack.add_argument("--quiet", action="store_true", help="no progress, no summary")

    run = command("run", _run, "do what a config says: a start, one stage after another, files")
    run.add_argument("config", nargs="?", default=None, help="TOML file (docs/runs.md)")
    run.add_argument("--from", dest="source", metavar="RUN", default=None, help="instead of a config: a file that `edmd run` wrote, to be "
                     "repeated bit for bit")
    run.add_argument("--set", dest="overrides", metavar="KEY=VALUE", action="append", default=[], help="change a value of the config, such "
                     "as system.n=500 or stage.0.rate=1e-3 (stages count from 0); may be given several times")
    run.add_argument("--seed", type=int, default=None, help="short for --set seed=SEED")
    run.add_argument("--print-config", action="store_true", help="print the config with every key, its value and meaning; do nothing")
    run.add_argument("-o", "--output", default=None, help="H5MD file to write, instead of that of the config")
    run.add_argument("--overwrite", action="store_true", help="replace the output when it exists")
    run.add_argument("--quiet", action="store_true", help="no progress, no summary")

    resume = command("resume", _resume, "go on with an interrupted run from its last checkpoint, as if nothing had happened")
    resume.add_argument("file")
    resume.add_argument("--quiet", action="store_true", help="no progress, no summary")

    sweep = command("sweep", _sweep, "do many runs: grids, lists and draws of the parameters of a config, on all cores or on a cluster")
    sweep.add_argument("file", help="TOML file (docs/sweeps.md)")
    sweep.add_argument("--scheduler", default=None, help="local, slurm, or the address of a Dask scheduler (tcp://host:8786), instead of "
                       "that of the file")
    sweep.add_argument("--workers", type=int, default=None, help="processes, or SLURM jobs, at once (default: those of the file, or all "
                       "cores)")
    sweep.add_argument("--set", dest="overrides", metavar="KEY=VALUE", action="append", default=[], help="change a value of the file, such "
                       "as replicas=5 or run.system.n=500; may be given several times")
    sweep.add_argument("--seed", type=int, default=None, help="short for --set seed=SEED")
    sweep.add_argument("-o", "--output", default=None, help="directory of the sweep, instead of that of the file")
    sweep.add_argument("--quiet", action="store_true", help="no progress, no summary")

    info = command("info", _info, "tell what is in a file")
    info.add_argument("file")
    info.add_argument("--contact-gap", type=float, default=None, help=CONTACT_GAP)
    info.add_argument("--json", action="store_true", help="for machines: one JSON object, null for what is not known")

    verify = command("verify", _verify, "check every frame of a file for overlaps, in double precision")
    verify.add_argument("file")

    plot = command("plot", _plot, "draw pressure and packing fraction along a run")
    plot.add_argument("--no-title", action="store_true", help="leave out the line about bodies and parameters")
    render = command("render", _render, "draw a picture of the bodies, or with --frames a movie")
    for drawing, suffix in ((plot, "plot"), (render, "picture")):
        drawing.add_argument("file")
        drawing.add_argument("-o", "--output", default=None, help=f"picture to write (default: beside the file, FILE.{suffix}.png)")
        drawing.add_argument("--overwrite", action="store_true", help="replace the output when it exists")
        drawing.set_defaults(suffix=suffix)
    render.add_argument("--frame", type=int, default=-1, help="frame to draw; negative counts from the end")
    render.add_argument("--frames", default=None, metavar="START:STOP:STEP", help="frames of a movie instead, as in Python, ':' for all; "
                        "OUTPUT is then a folder for pictures 00000.png, 00001.png, ... (default: beside the file, FILE.movie), or a .gif")
    render.add_argument("--per-second", type=float, default=25.0, help="pictures a second in a .gif")
    render.add_argument("--colour", "--color", choices=["orientation", "species", "contacts"], default="orientation")
    render.add_argument("--contact-gap", type=float, default=None, help=CONTACT_GAP)
    render.add_argument("--size", type=int, nargs=2, default=[900, 900], metavar=("WIDTH", "HEIGHT"), help="in pixels")

    export = command("export", _export, "write a run for other programs: extended XYZ (ASE, OVITO), GSD (HOOMD), LAMMPS data or dump")
    export.add_argument("file")
    export.add_argument("-o", "--output", required=True, help="file to write; its suffix tells the format: .xyz or .extxyz, .gsd, .data, "
                        ".dump or .lammpstrj")
    export.add_argument("--format", default=None, help="extxyz, gsd, lammps-data or lammps-dump, whatever the suffix")
    export.add_argument("--frames", default=None, metavar="START:STOP:STEP", help="frames to write, as in Python, or one number; "
                        "--frames=-1 is the last (default: all; of LAMMPS data, which hold one, the last)")
    export.add_argument("--overwrite", action="store_true", help="replace the output when it exists")
    return parser


def _pack(options):
    from edmd.outputs import check_output
    from edmd.packing import pack
    from edmd.progress import Progress

    check_output(options.output, options.overwrite)
    observers = [] if options.quiet else [Progress(options.until_pressure)]
    packing = pack(options.n, options.semi_axes, options.rate, options.seed, options.until_pressure, options.fluid_rate,
                   options.start_fraction, options.melt, output=options.output, overwrite=options.overwrite, observers=observers)
    for observer in observers:
        observer.close()
    if not options.quiet:
        _say({"packing fraction": f"{packing.packing_fraction:.6f}", "reduced pressure": f"{packing.pressure:.3g}",
              "contacts a body": f"{packing.mean_contact_number:.3f}", "rattlers": int(packing.rattlers.sum()),
              "nematic order": f"{packing.nematic_order:.4f}", "collisions": packing.collisions,
              "collisions / s": f"{packing.collisions / packing.seconds:,.0f} (CPU time, compilation included)", "file": options.output})
    return 0


def _run(options):
    from edmd.config import DEFAULT, config_text, read_config
    from edmd.runs import rebuilt, run

    digest, overrides = None, [*options.overrides, *([] if options.seed is None else [f"seed={options.seed}"])]
    if options.config and options.source:
        raise ValueError("a config and --from: expected one of them")
    if options.source:
        config, digest = rebuilt(options.source)
        if overrides:
            digest = None
        if not options.output and not options.print_config:
            raise ValueError("--from without --output: expected the name of the file to write")
    elif options.config or options.print_config:
        config = options.config or DEFAULT
    else:
        raise ValueError("no config: expected a TOML file (edmd run --print-config > run.toml makes one) or --from RUN")
    config = read_config(config, overrides)
    if options.print_config:
        print(config_text(config), end="")
        return 0
    output = options.output or config.output.file
    return _told(options, output, run(config, (), output, options.overwrite, progress=not options.quiet, start_digest=digest))


def _resume(options):
    from edmd.runs import RunComplete, resume

    try:
        simulation = resume(options.file, progress=not options.quiet)
    except RunComplete:
        if not options.quiet:
            print(f"{options.file}: the run is complete, nothing is left to do")
        return 0
    return _told(options, options.file, simulation)


def _sweep(options):
    from edmd.sweeps.campaign import carry_out, failures_in_words
    from edmd.sweeps.file import read_sweep

    short = {"scheduler": options.scheduler, "workers": options.workers, "seed": options.seed, "directory": options.output}
    file = read_sweep(options.file, [*options.overrides, *(f"{key}={value}" for key, value in short.items() if value is not None)])
    swept = carry_out(file.config or file.run, file.design(), file.directory, file.scheduler, file.workers, file.slurm, file.seed,
                      file.replicas, file.retries, file.plot, not options.quiet)
    if not options.quiet:
        _say({"runs": len(swept.table["run"]), "failed": len(swept.failed), "files": ", ".join(map(str, swept.files))})
        if all(path.suffix != ".parquet" for path in swept.files):
            print("edmd sweep: no table.parquet without pyarrow: pip install 'edmd[sweep]'", file=sys.stderr)
    if swept.failed:
        print(f"edmd sweep: {failures_in_words(swept)}", file=sys.stderr)
    return FAILED if swept.failed else 0


def _told(options, path, simulation):
    spared = simulation.contact_time_collisions
    if not options.quiet:
        _say({"packing fraction": f"{simulation.packing_fraction:.6f}", "reduced pressure": f"{simulation.compressibility_factor:.6g}",
              "temperature": f"{simulation.temperature:.6g}", "nematic order": f"{simulation.nematic_order:.4f}",
              "time": f"{simulation.time:.6g}", "collisions": simulation.collisions,
              **({"made elastic (TC)": spared} if spared else {}), "file": path})
    return 0


def _info(options):
    import json
    from math import isfinite

    import numpy as np

    from analysis import summarize
    from edmd.config import config_text
    from edmd.trajectory import open_run

    with open_run(options.file) as file:
        frames = len(file["particles/trajectory/position/step"])
        own = {name: value.item() if isinstance(value, np.generic) else value for name, value in file["edmd"].attrs.items()}
    own |= {name: json.loads(own[name]) for name in ("parameters", "rule") if name in own}
    gap = _contact_gap(options)
    summary = summarize(options.file, gap)
    whole = summary["frames"]
    if options.json:
        known = {name: None if isinstance(value, float) and not isfinite(value) else value for name, value in (own | summary).items()}
        print(json.dumps({"file": options.file, **known, "contact_gap": gap}, indent=1))
        return 0
    spared = own.get("contact_time_collisions", 0)
    try:
        parameters = config_text(own["parameters"], others=False)
    except ValueError:                          # a script's own
        parameters = json.dumps(own["parameters"], indent=1)
    _say({"written by": f"edmd {own['version']}, {own['created']}", "platform": own["platform"], "seed": own["seed"],
          "rule": _in_words(own.get("rule", {"kind": "elastic"})),
          **({"made elastic (TC)": spared} if spared else {}), "complete": "yes" if own["complete"] else "no",
          "frames": f"{whole} of {frames}: the others are not whole (edmd verify)" if whole < frames else whole,
          "bodies": summary["bodies"],
          "time": f"{summary['time']:.6g}", "collisions": summary["collisions"], "packing fraction": f"{summary['packing_fraction']:.9f}",
          "reduced pressure": f"{summary['reduced_pressure']:.4g} (since the frame before)",
          "contacts a body": f"{summary['contact_number']:.3f} (gap below {gap:.1e}; of those that are held)",
          "rattlers": summary["rattlers"], "nematic order": f"{summary['nematic_order']:.4f}"})
    print(f"\nparameters:\n\n{parameters.rstrip()}")
    return 0


def _contact_gap(options):
    """The gap that was asked for, or one that fits how far the run was compressed."""
    from edmd.packing import closed_gap
    from edmd.runs import rebuilt

    if options.contact_gap is not None:
        return options.contact_gap
    try:
        last = rebuilt(options.file)[0].stages[-1]
    except ValueError:                          # of a script
        last = None
    return closed_gap(getattr(last, "until_pressure", None) or JAMMED)


def _in_words(rule):
    return ", ".join(str(value) if name == "kind" else f"{name} {value:g}" for name, value in rule.items())


def _verify(options):
    from math import inf

    from edmd.trajectory import verify_file

    began = time.process_time()
    frames, smallest, wrong = verify_file(options.file)
    for problem in wrong:
        print(f"edmd verify: {problem}", file=sys.stderr)
    _say({"frames": frames, "closest pair touches when scaled by": "none was read" if smallest == inf else f"1 {smallest - 1:+.3e}",
          "problems": len(wrong),
          "seconds": f"{time.process_time() - began:.1f}"})
    return FAILED if wrong else 0


def _plot(options):
    from analysis import plot_compression

    return _draw(options, lambda output: plot_compression(options.file, output, not options.no_title))


def _render(options):
    from analysis import render

    if options.frames is not None:
        return _render_series(options)
    return _draw(options, lambda output: render(options.file, output, options.frame, options.colour, tuple(options.size),
                                                  contact_gap=_contact_gap(options)))


def _render_series(options):
    from pathlib import Path

    from analysis import render_series
    from edmd.exchange import selected
    from edmd.outputs import check_output
    from edmd.trajectory import open_run

    with open_run(options.file) as file:
        frames = selected(options.frames, len(file["particles/trajectory/position/step"]))
    output = Path(options.output or f"{options.file.removesuffix('.h5md')}.movie")
    if output.suffix.lower() == ".gif":
        check_output(output, options.overwrite)
    elif output.exists() and not output.is_dir():
        raise ValueError(f"output = {str(output)!r}: is a file; expected the name of a folder or of a .gif")
    elif output.is_dir() and any(output.iterdir()) and not options.overwrite:
        raise ValueError(f"output = {str(output)!r}: the folder is not empty; choose another name or overwrite it")
    if output.is_dir():
        for picture in output.glob("[0-9][0-9][0-9][0-9][0-9].png"):            # of a longer movie, perhaps
            picture.unlink()
    written = render_series(options.file, output, frames, options.colour, tuple(options.size), contact_gap=_contact_gap(options),
                            per_second=options.per_second)
    _say({"frames": len(frames), "output": output} | ({} if output.suffix.lower() == ".gif" else {
        "a movie": f"ffmpeg -framerate {options.per_second:g} -i {Path(written[0]).parent}/%05d.png -pix_fmt yuv420p {output}.mp4"}))
    return 0


def _export(options):
    from edmd.exchange import export

    frames = export(options.file, options.output, options.format, options.frames, options.overwrite, progress=True)
    _say({"frames": frames, "file": options.output})
    return 0


def _draw(options, draw):
    from edmd.outputs import check_output
    from edmd.trajectory import open_run

    open_run(options.file).close()
    output = check_output(options.output or f"{options.file.removesuffix('.h5md')}.{options.suffix}.png", options.overwrite)
    if output.suffix.lower() not in PICTURES:
        raise ValueError(f"output = {str(output)!r}: expected a name that ends in {', '.join(PICTURES)}")
    draw(output)
    print(output)
    return 0


def _say(facts):
    width = max(map(len, facts))
    for name, value in facts.items():
        print(f"{name:<{width}}  {value}")
