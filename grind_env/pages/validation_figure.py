"""The figure of the validation page: published series beside the model with its uncertainty."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.files import write_atomically
from grind_env.machine.job import Job, Part, Setup
from grind_env.machine.job.drawn_machines import draw_machine, usual_uncertainty
from grind_env.machine.job.job_entries import entries_of
from grind_env.process.catalogue import USUAL, load_catalogue
from grind_env.render.figures import new_figure
from grind_env.toml import read_toml
from grind_env.validation import measured_data
from grind_env.validation.declared_checks import CHECKS, Measurement
from grind_env.validation.published_checks import CASES, magnitude
from grind_env.validation.rig import Rig
from grind_env.validation.valve_alloys import RESPONSES, WHEELS, AlloyRuns, measured, simulated

#: number of machines drawn for a band, seed of the draws, and percentiles of the ends of the band
MACHINES, SEED, BAND = 40, 24, (5.0, 95.0)
INK, SHADE, LINES = "#111111", "#8fb3d1", ("-", "--", ":")


class PublishedSeries(NamedTuple):
    """Published numbers, and numbers of the model at the same points."""

    name: str
    published: Array  #: published numbers, shape (points,); NaN where nothing is published
    model: Array  #: numbers of the model, shape (machines, points); the first machine is that of the catalogue
    factor: Any = 1.0  #: factor by which the published numbers are uncertain

    def over_mean(self) -> "PublishedSeries":
        """Return the series with published numbers and model divided by their own geometric means."""
        sides = (self.published, self.model)
        published, model = (each / np.exp(np.log(each).mean(axis=-1, keepdims=True)) for each in sides)
        return self._replace(published=published, model=model)

    def with_errors(self) -> "PublishedSeries":
        """Return the series with the errors of level and trend of the model in its name."""
        level = np.exp(np.mean(np.log(self.model[0] / self.published)))
        off, constant = (100.0 * np.std(np.log(each / self.published)) for each in (self.model[0], 1.0))
        factor = f"× {level:.1f}, " if abs(level - 1.0) > 0.05 else ""
        verdict = ", against" if off > constant / 2.0 else ""
        return self._replace(name=f"{self.name}: {factor}{off:.0f} % ({constant:.0f} %){verdict}")


def column(rows: Sequence[Mapping[str, str]], name: str) -> Array:
    """Return the numbers of a column."""
    return np.array([float(row[name]) for row in rows])


def by_machine(points: Sequence[Callable[[Rig], Any]], material: str = "aisi_52100", **entries: str) -> Array:
    """Return the points of the machine of the catalogue, then of machines drawn from the uncertainty of entries."""
    catalogue = load_catalogue()
    setup: Any = {kind: getattr(catalogue, kind)(name) for kind, name in {**USUAL, **entries}.items()}
    part = Part(material=catalogue.material(material), length=200, width=20, stock=0.1, scrap_cost=0)
    job = Job(part=part, setup=Setup(**setup))
    unknown, machines = usual_uncertainty(job), [Rig(catalogue)]
    for number in range(MACHINES):
        drawn = entries_of(draw_machine(job, unknown, unknown.root, SEED, number)).items()
        tables: Any = {f"{kind}s": {**getattr(catalogue, f"{kind}s"), each.name: each} for kind, each in drawn}
        machines.append(Rig(replace(catalogue, **tables)))
    return np.array([[point(rig) for point in points] for rig in machines])


def valves(response: str) -> Iterator[PublishedSeries]:
    """Return wear or Ra of three wheels in a valve alloy."""
    for wheel in WHEELS:
        place = AlloyRuns._fields.index(response)
        model = by_machine([partial(simulated, wheel=wheel)], "inc751", wheel=wheel.entry)[:, 0, place]
        name = f"{wheel.measured} {wheel.speed:g} m/s"
        yield PublishedSeries(name, measured(wheel)[place], model).over_mean().with_errors()


def rotary() -> Iterator[PublishedSeries]:
    """Return Ra over overlap and speed ratio of a rotary dresser."""
    names = ("dressing_overlap_Ud", "dressing_speed_ratio_qd")
    runs = sorted(measured_data.rows("flat_grinding_L8_dressing"), key=lambda run: [run[name] for name in names])
    # .28 mm of a diamond touch the wheel at the usual depth
    setups = [f"lead: {0.28 / float(run[names[0]])}; dresser.speed_ratio: {run[names[1]]}" for run in runs]
    points = [Measurement("Rg 1", "fresh", f"dresser: rotary; {setup}") for setup in setups]
    yield PublishedSeries("Ra", column(runs, "Ra_um"), by_machine(points, dresser="rotary")).over_mean().with_errors()


def bearings() -> Iterator[PublishedSeries]:
    """Return Ra of bearing steel ground with cBN, without spark-out and with it."""
    runs = [run for run in measured_data.rows("aisi52100_cbn_conditions") if float(run["Ra_um"]) < 0.2]
    Ra, deviation = column(runs, "Ra_um"), column(runs, "deviation_um")
    usual = "wheel: b126; diameter: 139; constant_surface_speed: 1; lead: 0.04; depth: 0.005; machine.power_limit: 5e5"
    cuts = ["; ".join(f"{key}: {run[key]}" for key in ("wheel_speed", "table_speed", "downfeed")) for run in runs]
    for name, quantity in (("no spark-out", "Ra 10"), ("spark-out", "sparked_out")):
        points = [Measurement(quantity, "sharp", f"{usual}; {each}") for each in cuts]
        yield PublishedSeries(name, Ra, by_machine(points, wheel="b126"), 1.0 + deviation / Ra).with_errors()


def partition() -> Iterator[PublishedSeries]:
    """Return the share of the heat that enters a part of cast iron, over the depth."""
    depths = (5, 8, 10, 12, 15, 18, 20, 25, 30)
    references = {check.name.removeprefix("partition "): check.reference for check in CHECKS}
    for fluid, rows in (("dry", {10: "dry"}), ("emulsion", {10: "wet", 25: "boiling"})):
        known: Any = {depth: references[row] for depth, row in rows.items()}
        setup = f"material: grey_cast_iron; table_speed: 40; fluid: {fluid}; downfeed: "
        points = [Measurement("eps", "dulled 0.025", f"{setup}{depth / 1000.0}") for depth in depths]
        model = by_machine(points, "grey_cast_iron", fluid=fluid)
        said = ", ".join(f"{model[0, depths.index(depth)]:.2f} ({value})" for depth, value in known.items())
        yield PublishedSeries(f"{fluid}: {said}", np.array([known.get(depth, np.nan) for depth in depths]), model)


def forces() -> Iterator[PublishedSeries]:
    """Return forces and power beside remembered values."""
    quantities = ("normal force sharp", "tangential force sharp", "power sharp")
    rows = [row for each in quantities for row in measured_data.rows("expected_magnitudes") if row["quantity"] == each]
    low, high, found = column(rows, "low"), column(rows, "high"), []
    for row in rows:
        setup = dict(part.split(": ") for part in CASES[row["case"]][1].split("; ") if part)
        entries = {kind: setup[kind] for kind in ("material", "wheel") if kind in setup}
        found.append(by_machine([magnitude(row).measure], **entries)[:, 0])
    held = sum(low[k] <= each[0] <= high[k] for k, each in enumerate(found))
    name = f"within {held} of {len(rows)} ranges"
    yield PublishedSeries(name, np.sqrt(low * high), np.transpose(found), np.sqrt(high / low))


def draw(axes: Any, panel: Mapping[str, Any], members: Sequence[PublishedSeries]) -> None:
    """Draw the series of a panel, as `series.toml` describes it."""
    x, apart, marks = np.array(panel["x"], float), panel.get("apart", 1.0), panel.get("marks", "os^")
    for place, series in enumerate(members):
        shift, style = apart**-place, {"color": INK, "marker": marks[place], "ms": 4.5}
        bands = np.percentile(series.model, BAND, axis=0)
        published, model, low, high = (shift * each for each in (series.published, series.model[0], *bands))
        for part in np.arange(len(x)).reshape(-1, panel["joined"]):
            along = x[part] if len(part) > 1 else x[part] + np.array((-0.35, 0.35))
            bottom, top, line = (np.broadcast_to(each[part], along.shape) for each in (low, high, model))
            axes.fill_between(along, bottom, top, color=SHADE, alpha=0.6, lw=0)
            axes.plot(along, line, LINES[place], color=INK, lw=1.2)
        least, most = published / series.factor, published * series.factor
        axes.errorbar(x, published, (published - least, most - published), fmt="none", ecolor=INK, lw=0.9)
        inside = (low <= most) & (least <= high)
        for of, fill in ((inside, INK), (~inside, "white")):
            axes.plot(x[of], published[of], ls="none", mfc=fill, **style)
        axes.plot([], [], LINES[place], label=series.name, **style)


def plot_series(path: Path) -> str:
    """Draw the figure and return its caption, Markdown; needs matplotlib."""
    from matplotlib.ticker import LogLocator, NullLocator

    panels = read_toml(Path(__file__).with_name("series.toml"))
    series = {name: tuple(valves(response)) for response, name in RESPONSES.items()}
    series |= {make.__name__: tuple(make()) for make in (rotary, bearings, partition, forces)}
    figure, caption = new_figure(8.0, 6.2), [panels.pop("note").format(machines=MACHINES)]
    for letter, (name, panel), axes in zip("abcdef", panels.items(), figure.subplots(2, 3).flat, strict=True):
        draw(axes, panel, series[name])
        axes.set_yscale("log")
        low, high = axes.get_ylim()
        axes.set_ylim(low * (low / high) ** (0.05 + 0.09 * len(series[name])), high)  # below is the legend
        axes.yaxis.set_major_locator(NullLocator() if "apart" in panel else LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_title(f"{letter}  {panel['title']}", fontsize=9, loc="left")
        axes.set_xticks([float(place) for place in panel["ticks"]], panel["ticks"].values())
        axes.tick_params(labelsize=8)
        axes.legend(fontsize=7.5, frameon=False, loc="lower left", borderpad=0)
        axes.spines[["top", "right"]].set_visible(False)
        judged = "; ".join(each.name for each in series[name])
        caption.append(f"- **{letter}, {panel['title']}**: {' '.join(panel['caption'].split())}. {judged}.")
    write_atomically(path, lambda temporary: figure.savefig(temporary, dpi=130))
    return "\n".join(caption)
