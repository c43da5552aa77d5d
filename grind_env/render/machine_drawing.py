"""The machine: wheel, dresser and part; the wheel's face under a lens; and the tray of parts."""

import math
from typing import NamedTuple

from grind_env.process.cost import SCRAP_BELOW
from grind_env.render import palette as ink
from grind_env.render.canvas import Box, Canvas, Point
from grind_env.render.picture_data import EpisodePicture

RIM = 0.13  #: width of the coloured rim as a share of the radius of a new wheel
GRAINS = 48  #: number of marks on the rim
#: largest share by which a worn wheel is drawn smaller, and the lost radius at which half of it is reached, mm
SHRINK, HALF_SHRINK = 0.45, 4.0

#: distance of the finished surface from the top, and heights of the part, the table and the space for stock, all as
#: shares of the height of the panel
SURFACE, PART, TABLE, STOCK_ROOM = 0.735, 0.075, 0.06, 0.10
TRAVEL = 0.21  #: distance of the table from the middle to a reversal point, as a share of the width of the panel
LONGEST = 0.34  #: length of the longest part as a share of the width of the panel
DRESSER_GAP = 0.06  #: distance from the part to the diamond, as a share of the width of the panel

CHUCK_PITCH = 8.0  #: distance of the pole strips of the magnetic chuck, px
DRESSES = ("no dress", "one dress")
SPARKS = 14
PATCHES = 7  #: number of burn marks along a part


class Placement(NamedTuple):
    """Places of the objects in the panel, px."""

    panel: Box
    centre: Point  #: centre of the wheel
    new_radius: float
    radius: float
    surface: float  #: y of the finished surface
    top: float  #: y of the upper edge of the stock that is still on the part
    part: Box  #: the part without this stock


def placement(view: EpisodePicture, panel: Box) -> Placement:
    """Return the places of the objects."""
    middle, part = 0.5 * (panel.left + panel.right), view.part
    surface = panel.top + SURFACE * panel.height
    top = surface - STOCK_ROOM * panel.height * max(part.left, 0.0) / view.extent.thickest
    half = 0.5 * LONGEST * panel.width * part.length / view.extent.longest
    table = _table_offset(view, panel, half)
    new_radius = min(0.29 * panel.height, 0.21 * panel.width)
    radius = new_radius * (1.0 - SHRINK * view.radius_lost / (view.radius_lost + HALF_SHRINK))
    return Placement(
        panel=panel,
        centre=(middle, top - radius),
        new_radius=new_radius,
        radius=radius,
        surface=surface,
        top=top,
        part=Box(middle + table - half, surface, middle + table + half, surface + PART * panel.height),
    )


def draw_machine(canvas: Canvas, panel: Box, view: EpisodePicture) -> None:
    """Draw the machine in its panel."""
    place = placement(view, panel)
    canvas.rectangle(panel, ink.PANEL, outline=ink.EDGE, radius=6.0)
    canvas.arc(place.centre, place.new_radius + 12.0, 9.0, (188.0, 352.0), ink.GUARD)
    _draw_table(canvas, place)
    _draw_part(canvas, place, view)
    _draw_dresser(canvas, place, view)
    _draw_coolant(canvas, place, view)
    _draw_wheel(canvas, place, view)
    _label_machine(canvas, place, view)


def _table_offset(view: EpisodePicture, panel: Box, half: float) -> float:
    """Return the horizontal distance of the part's middle from the wheel centre, px."""
    if view.instant is None:
        return 0.0
    if view.instant.dressing:
        return half + DRESSER_GAP * panel.width
    return view.instant.table * TRAVEL * panel.width


def _draw_table(canvas: Canvas, place: Placement) -> None:
    panel, part = place.panel, place.part
    table = Box(
        max(part.left - 0.13 * panel.width, panel.left + 1.0),
        part.bottom,
        min(part.right + 0.06 * panel.width, panel.right - 1.0),
        part.bottom + TABLE * panel.height,
    )
    canvas.rectangle(table, ink.TABLE, radius=2.0)
    for k in range(1, int(table.width / CHUCK_PITCH)):
        x = table.left + CHUCK_PITCH * k
        canvas.line([(x, table.top + 3.0), (x, table.top + 0.6 * table.height)], ink.BED)
    bed = Box(panel.left + 10.0, table.bottom, panel.right - 10.0, table.bottom + 5.0)
    canvas.rectangle(bed, ink.BED, radius=1.0)


def _draw_part(canvas: Canvas, place: Placement, view: EpisodePicture) -> None:
    part = place.part
    canvas.rectangle(part, ink.STEEL)
    if place.surface - place.top >= 0.5:
        canvas.rectangle(Box(part.left, place.top, part.right, part.top), ink.STOCK)
        step = 6.0
        for k in range(int(part.width / step)):
            x = part.left + (k + 0.5) * step
            canvas.line([(x, part.top), (x + 2.0, place.top)], ink.STEEL, 0.7)
    if view.last is not None:
        ground = part._replace(top=min(place.top, part.top))
        canvas.rectangle(ground._replace(bottom=ground.top + 2.0), ink.BRIGHT)
        if "burn" in view.last.faults:
            _draw_burn(canvas, ground, view.last.rise / view.last.limits.rise)


def _draw_burn(canvas: Canvas, part: Box, ratio: float) -> None:
    """Draw burn marks in the temper colours, the hottest in the middle of each."""
    for ring in (1.0, 0.75, 0.5, 0.25):
        colour = ink.burn_colour(1.0 + (ratio - 1.0) * (1.1 - ring))
        for k in range(PATCHES):
            x = part.left + part.width * (k + 0.5 + 0.12 * math.sin(2.9 * k)) / PATCHES
            across = ring * part.width / PATCHES * (0.38 + 0.06 * math.sin(2.4 * k))
            deep = ring * part.height * (0.40 + 0.10 * math.sin(1.7 * k + 1.0))
            rim = [math.pi * n / 10.0 for n in range(11)]
            canvas.polygon([(x + across * math.cos(a), part.top + deep * math.sin(a)) for a in rim], colour)


def _draw_dresser(canvas: Canvas, place: Placement, view: EpisodePicture) -> None:
    """Draw the diamond on the table; its tip is as wide as its wear flat, much enlarged."""
    panel, part = place.panel, place.part
    x = part.left - DRESSER_GAP * panel.width
    dressing = view.instant is not None and view.instant.dressing
    tip = place.centre[1] + place.radius if dressing else place.surface - 2.0
    canvas.polygon(
        [(x - 11.0, part.bottom), (x - 8.0, tip + 8.0), (x + 8.0, tip + 8.0), (x + 11.0, part.bottom)], ink.FLANGE
    )
    flat = 1.0 + 12.0 * view.wheel.wd
    diamond = [(x - flat, tip), (x + flat, tip), (x + 7.0, tip + 6.0), (x, tip + 15.0), (x - 7.0, tip + 6.0)]
    canvas.polygon(diamond, ink.DIAMOND)
    canvas.line([*diamond, diamond[0]], ink.INK, 0.7)


def _draw_coolant(canvas: Canvas, place: Placement, view: EpisodePicture) -> None:
    """Draw the nozzle and, while the wheel cuts, its jet into the gap between wheel and part."""
    x, y = place.centre[0], place.centre[1] + place.radius
    tip = (x + 0.95 * place.new_radius, place.surface - 0.36 * place.new_radius)
    if view.instant is not None and not view.instant.dressing:
        canvas.polygon([(tip[0] - 4.0, tip[1] - 1.0), (tip[0] + 1.0, tip[1] + 4.0), (x + 3.0, y)], ink.COOLANT)
    canvas.polygon(
        [
            (tip[0] - 5.0, tip[1] - 2.0),
            (tip[0] + 2.0, tip[1] + 5.0),
            (tip[0] + 24.0, tip[1] - 6.0),
            (tip[0] + 24.0, tip[1] - 17.0),
        ],
        ink.FLANGE,
    )
    canvas.rectangle(Box(tip[0] + 23.0, tip[1] - 18.0, tip[0] + 44.0, tip[1] - 5.0), ink.FLANGE)


def _draw_wheel(canvas: Canvas, place: Placement, view: EpisodePicture) -> None:
    (x, y), radius = place.centre, place.radius
    spin = 2.0 * math.pi * (view.instant.spin if view.instant else 0.0)

    def at(distance: float, angle: float) -> Point:
        return x + distance * math.cos(angle), y + distance * math.sin(angle)

    for k in range(0, 60, 2):
        ghost = 2.0 * math.pi * k / 60.0
        ends = [at(place.new_radius, ghost), at(place.new_radius, ghost + 0.05)]
        if ends[0][1] < place.top - 3.0:
            canvas.line(ends, ink.GREY, 0.7)
    colour = ink.wear_colour(view.wheel.A)
    canvas.disc((x, y), radius, colour)
    rim = RIM * place.new_radius
    darker = ink.mix(colour, ink.INK, 0.35)
    for k in range(GRAINS):
        a = spin + 2.0 * math.pi * k / GRAINS
        out, inner = radius - 1.5, radius - rim * (0.75 if k % 3 else 0.5)
        canvas.line([at(out, a), at(inner, a)], darker)
    canvas.disc((x, y), radius - rim, ink.WHEEL)
    canvas.disc((x, y), 0.36 * place.new_radius, ink.FLANGE)
    canvas.disc((x, y), 0.33 * place.new_radius, ink.mix(ink.FLANGE, ink.PANEL, 0.25))
    for k in range(6):
        canvas.disc(at(0.25 * place.new_radius, spin + math.pi * k / 3.0), 2.0, ink.BED)
    canvas.disc((x, y), 0.13 * place.new_radius, ink.BED)
    if view.instant is not None and not view.instant.dressing:
        _draw_sparks(canvas, (x, y + radius), spin)


def _draw_sparks(canvas: Canvas, at: Point, spin: float) -> None:
    for k in range(SPARKS):
        phase = (0.37 * k + 3.1 * spin) % 1.0
        angle = math.radians(2.0 + 24.0 * k / SPARKS)
        near, far = 8.0 + 52.0 * phase, 16.0 + 68.0 * phase
        ends = [(at[0] - s * math.cos(angle), at[1] - 1.0 - s * math.sin(angle)) for s in (near, far)]
        canvas.line(ends, ink.mix(ink.SPARK, ink.BRICK, 0.5 * phase), 1.0)


def _label_machine(canvas: Canvas, place: Placement, view: EpisodePicture) -> None:
    panel, block = place.panel, view.instant or view.last
    left, right, top, base = panel.left + 12.0, panel.right - 12.0, panel.top + 19.0, panel.bottom - 9.0
    canvas.text((left, top), f"wheel radius {0.5 * view.wheel.ds:.2f} mm", 12)
    canvas.text((left, top + 16.0), f"{view.radius_lost:.2f} mm gone (drawn larger)", 11, ink.GREY)
    if block is not None:
        canvas.text((right, top), f"E {block.speed:.0f} mm/min", 12, ink.BLUE, "rs", strong=True)
        dresses = DRESSES[block.executions] if block.executions < len(DRESSES) else f"{block.executions} dresses"
        canvas.text((right, top + 16.0), f"D {block.executions}, {dresses}", 12, ink.ORANGE_TEXT, "rs", strong=True)
    canvas.text((left, base), view.part.description, 11, ink.GREY)
    bad = view.last is not None and (view.last.faults or (view.last.finished and view.last.good < SCRAP_BELOW))
    canvas.text((right, base), view.verdict, 12, ink.BRICK if bad else ink.TEAL_TEXT, "rs", strong=True)


FACE_GRAINS = 9
LOADED = 0.7  #: share of the height of the grains to which a fully loaded wheel is filled


def draw_lens(canvas: Canvas, panel: Box, view: EpisodePicture) -> None:
    """Draw grains whose tips flatten with the wear-flat area, pores that fill as the wheel loads, and the scale."""
    canvas.rectangle(panel, ink.PANEL, outline=ink.EDGE, radius=6.0)
    face = Box(panel.left + 10.0, panel.top + 8.0, panel.left + 0.60 * panel.width, panel.bottom - 8.0)
    _draw_face(canvas, face, view)
    _draw_scale(canvas, Box(face.right + 22.0, panel.top, panel.right - 12.0, panel.bottom), view)


def _draw_face(canvas: Canvas, face: Box, view: EpisodePicture) -> None:
    wheel = view.wheel
    bond = face.bottom - max(0.36 * face.height, 17.0)
    pitch = face.width / FACE_GRAINS
    cut, colour = ink.dullness(wheel.A), ink.wear_colour(wheel.A)
    tallest = bond - face.top - 2.0
    canvas.rectangle(Box(face.left, bond - LOADED * wheel.lam * tallest, face.right, bond), ink.FLANGE)
    for k in range(FACE_GRAINS):
        x = face.left + (k + 0.5) * pitch
        # a grain is a pyramid whose tip has been worn to a flat: the lower it stands, the wider the flat
        top = bond - tallest * (0.94 + 0.06 * math.sin(2.3 * k)) * (1.0 - 0.5 * cut)
        lean = 0.08 * pitch * math.sin(5.1 * k)
        flat, foot = pitch * (0.05 + 0.27 * cut), pitch * 0.43
        canvas.polygon(
            [(x - foot, bond), (x + lean - flat, top), (x + lean + flat, top), (x + foot, bond)],
            ink.GRAIN if k % 2 else ink.mix(ink.GRAIN, ink.WHEEL, 0.3),
        )
        canvas.line([(x + lean - flat - 0.5, top), (x + lean + flat + 0.5, top)], colour, 3.0)
    canvas.rectangle(Box(face.left, bond, face.right, face.bottom), ink.WHEEL, radius=2.0)
    canvas.text((face.left + 8.0, face.bottom - 5.0), "wheel face, enlarged", 11, ink.GREY)


def _draw_scale(canvas: Canvas, box: Box, view: EpisodePicture) -> None:
    wheel = view.wheel
    y = box.top + 0.30 * box.height
    canvas.text((box.left, y), "wear-flat area", 11, ink.GREY)
    canvas.text((box.right, y), f"{100.0 * wheel.A:.2f} %", 12, anchor="rs", strong=True)
    bar = Box(box.left, y + 0.12 * box.height, box.right, y + 0.12 * box.height + 7.0)
    steps = 40
    for k in range(steps):
        left = bar.left + bar.width * k / steps
        canvas.rectangle(
            Box(left, bar.top, left + bar.width / steps + 0.5, bar.bottom), ink.ramp(ink.WEAR, (k + 0.5) / steps)
        )
    x = bar.left + bar.width * ink.dullness(wheel.A)
    canvas.polygon([(x, bar.bottom - 1.0), (x - 5.0, bar.bottom + 7.0), (x + 5.0, bar.bottom + 7.0)], ink.INK)
    canvas.text((box.left, box.bottom - 0.13 * box.height), "loading", 11, ink.GREY)
    canvas.text((box.right, box.bottom - 0.13 * box.height), f"{100.0 * wheel.lam:.0f} %", 12, anchor="rs", strong=True)


def draw_tray(canvas: Canvas, box: Box, view: EpisodePicture) -> None:
    """Draw one cell per part: scrap high and struck out, a good part lower and plain, a part to come as a line."""
    parts = [block for block in view.ground if block.finished]
    canvas.text(
        (box.right, box.bottom),
        f"{view.scrapped} scrap",
        12,
        ink.BRICK if view.scrapped else ink.TEAL_TEXT,
        "rs",
        strong=True,
    )
    pitch = (box.width - 62.0) / view.extent.parts
    cell = min(pitch - min(2.0, 0.25 * pitch), 14.0)
    for k in range(view.extent.parts):
        left = box.left + pitch * k
        if k >= len(parts):
            canvas.rectangle(Box(left, box.bottom - 3.0, left + cell, box.bottom), ink.EDGE)
        elif parts[k].good < SCRAP_BELOW:
            canvas.rectangle(Box(left, box.top, left + cell, box.bottom), ink.BRICK)
            canvas.line([(left + 1.0, box.bottom - 1.0), (left + cell - 1.0, box.top + 1.0)], ink.PANEL, 1.0)
        else:
            canvas.rectangle(Box(left, box.bottom - 0.6 * box.height, left + cell, box.bottom), ink.TEAL)
