"""Waves as they come from scanners: units, cycles, beats, flow that stands still and runs back."""

import numpy as np
import pytest
from seeds import seeds

from benchmarks.phantoms import stenosed_tube, vascular_tree
from SDFStentLib.flow import (
    BlockPart,
    FlowModel,
    Known,
    Network,
    Outlets,
    Part,
    Wave,
    channels_of,
    drop_over,
    flow_value,
    known_flow,
    read_wave,
    solved_by_svzerod,
    steady,
    svzerod_document,
    time_value,
    tree_between,
)
from SDFStentLib.flow.blocks import Stream, blocks_of
from SDFStentLib.flow.channels import Channel, Widths
from SDFStentLib.validation import InputError

MMHG = 133.322


def systole(count=21, cycle=0.8, peak=200.0, back=0.0):
    """Times and flows: a half sine over two fifths of a cycle, then blood stands still or runs back
    until seven eighths; the last row repeats the first."""
    time = np.linspace(0, cycle, count)
    part = time / cycle
    flow = np.where(part < 0.4, peak * np.sin(np.pi * part / 0.4), 0.0)
    flow -= np.where(
        (part >= 0.4) & (part < 0.875), back * np.sin(np.pi * (part - 0.4) / 0.475), 0.0
    )
    flow[-1] = flow[0]
    return time, flow


def wave_of(time, flow):
    return Wave(tuple(map(float, time)), tuple(map(float, flow)))


def sampled(wave, count):
    """So many flows at even times of the cycle."""
    return np.interp(np.arange(count) * wave.cycle / count, wave.time, wave.flow)


def average(time, flow, what=lambda q: q):
    """Of a quantity over the rows of a wave, the plain way."""
    at = np.linspace(time[0], time[-1], 400_001)
    return np.trapezoid(what(np.interp(at, time, flow)), at) / (time[-1] - time[0])


@pytest.fixture
def read(tmp_path):
    """Reads rows from a file."""

    def reads(time, flow, header="time_s,flow_mL/s", **more):
        path = tmp_path / "wave.csv"
        rows = [f"{t:.6g},{q:.6g}" for t, q in zip(time, flow, strict=True)]
        path.write_text("\n".join([*([header] if header else []), *rows, ""]), encoding="utf-8")
        return read_wave(path, **more)

    return reads


# Units


@pytest.mark.parametrize(
    ("header", "seconds", "milliliters"),
    [
        ("time_s,flow_mL/s", 1, 1),
        ("s,mL/s", 1, 1),
        ("Time [ms],Flow [mL/s]", 1e-3, 1),
        ("t_s,q_ml_min", 1, 1 / 60),
        ("Time (s),flow (mL/min)", 1, 1 / 60),
        ("time_ms,flow_L/min", 1e-3, 1000 / 60),
        ("t/ms,Q/(dL/min)", 1e-3, 100 / 60),
        ("time,flow_cm3/s", 1, 1),
        ("TIME_MIN,Flow [cm^3/s]", 60, 1),
        ("t [s],Q [m³/s]", 1, 1e6),
        ("t [s],net flow MPA m3_s", 1, 1e6),
        ("s,mL min-1", 1, 1 / 60),
        ("s,q_ml_min-1", 1, 1 / 60),
        ("t (sec),Q (ml·min⁻¹)", 1, 1 / 60),
        ("time_msec,Flow [mL.s-1]", 1e-3, 1),
        ("time (s),cm^3 s^-1", 1, 1),
        ("time (s),Q [m^3/s]", 1, 1e6),
        ("time (s),L per min", 1, 1000 / 60),
        ("time (s),flow lpm", 1, 1000 / 60),
        ("time (s),flow (cc/sec)", 1, 1),
    ],
)
def test_the_units_of_columns_are_read_as_units(read, header, seconds, milliliters):
    time, flow = systole(back=20)
    wave, cautions = read(time / seconds, flow / milliliters, header)
    assert not cautions
    assert wave.cycle == pytest.approx(0.8, rel=1e-5)
    assert wave.mean == pytest.approx(average(time, flow), rel=1e-4)
    assert wave.peak == pytest.approx(200, rel=1e-4)


@pytest.mark.parametrize(
    "unit",
    ["uL/min", "mL", "mL/h", "kg/s", "m/s", "cm/s", "mL/min/m2", "mL/beat", "ml/ms2", "mm/s"],
)
@pytest.mark.parametrize("header", ["flow_{}", "Flow [{}]", "q ({})"])
def test_a_unit_that_is_none_of_flow_is_refused_with_those_that_are(read, unit, header):
    bare = unit == "mL" and header == "flow_{}"
    with pytest.raises(InputError, match="L/min, cm3/s or m3/s") as error:
        read(*systole(), f"time_s,{header.format(unit)}")
    assert bare or unit in str(error.value)
    if not bare:  # nor is it a shape that a mean flow makes a wave
        with pytest.raises(InputError, match="L/min, cm3/s or m3/s"):
            read(*systole(), f"time_s,{header.format(unit)}", needs_unit=False)


def texts():
    """Files that say the same, as spreadsheets and consoles write them."""
    rows = [(0, 0), (0.1, 55.5), (0.2, 100.25), (0.3, 60), (0.45, 0), (0.8, 0)]
    plain = [(str(a), str(b)) for a, b in rows]
    comma = [(a.replace(".", ","), b.replace(".", ",")) for a, b in plain]
    for name, cells, divides in (
        ("semicolons", plain, ";"),
        ("semicolons and decimal commas", comma, ";"),
        ("tabs", plain, "\t"),
        ("tabs and decimal commas", comma, "\t"),
        ("blanks", plain, ", "),
    ):
        yield name, "\n".join(divides.join(row) for row in [("time_s", "flow_mL/s"), *cells])
    table = "\n".join(";".join(row) for row in comma)
    yield "no header", table
    yield "a row that names what divides", f"sep=;\r\ntime_s;flow_mL/s\r\n{table}\r\n;\r\n"
    yield "comments", f"# patient 3\ntime_s;flow_mL/s\n{table}\n# end"
    yield "an empty column", "time_s;flow_mL/s;\n" + "".join(f"{row};\n" for row in table.split())


@pytest.mark.parametrize(("name", "text"), [*texts()], ids=[name for name, _ in texts()])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_file_is_read_as_it_was_written(tmp_path, name, text, encoding):
    (tmp_path / "wave.csv").write_bytes(text.replace("flow", "Flu\xdf").encode(encoding))
    wave, cautions = read_wave(tmp_path / "wave.csv", needs_unit="no header" not in name)
    assert not cautions
    assert wave.cycle == pytest.approx(0.8)
    assert wave.peak == 100.25
    assert wave.mean == pytest.approx(23.075 / 0.8)  # trapezoids, by hand


@pytest.mark.parametrize(
    "rows",
    [
        ["0,0,0", "0,1,55,5", "0,2,100,2", "0,3,60,1"],
        ["0\t1,000", "40\t2,000", "80\t3,000", "120\t1,000"],
        ["0.1;1,000", "0.2;2,000", "0.3;3,000", "0.4;1,000"],
        ['0,"1,000"', '40,"2,000"', '80,"3,000"', '120,"1,000"'],
    ],
)
def test_commas_that_may_divide_thousands_are_refused(tmp_path, rows):
    path = tmp_path / "wave.csv"
    header = "t ms\tmL/min" if "\t" in rows[0] else "t,q"
    path.write_text("\n".join([header, *rows]), encoding="utf-8")
    with pytest.raises(InputError, match="rows of two numbers"):
        read_wave(path, needs_unit=False)


@pytest.mark.parametrize("header", ["Time [us]", "time_h", "t (frames)", "flow_mL/s", "phase_%"])
def test_a_unit_that_is_none_of_time_is_refused_with_those_that_are(read, header):
    with pytest.raises(InputError, match="a time in s, ms or min in the first column"):
        read(*systole(), f"{header},flow_mL/s")


def test_a_header_without_a_unit_tells_a_shape(read):
    time, flow = systole()
    for header in ("time_s,flow", "time,flow rate", ""):
        with pytest.raises(InputError, match="unit of the flow"):
            read(time, flow, header)
        assert known_flow(30.0, read(time, flow, header, needs_unit=False).wave).mean == 30.0


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("41.7mL/s", 41.7),
        ("2.5L/min", 2500 / 60),
        ("450 mL/min", 7.5),
        ("25dL/min", 2500 / 60),
        ("2500 mL min-1", 2500 / 60),
        ("41.7 cm^3 s^-1", 41.7),
        ("2.5 lpm", 2500 / 60),
    ],
)
def test_a_value_has_the_same_units(text, value):
    assert flow_value(text) == pytest.approx(value)
    assert flow_value(text.upper()) == pytest.approx(value)


def test_further_units_of_values():
    assert flow_value("4e-5m3/s") == pytest.approx(40)
    assert flow_value(".5cm3/s") == 0.5
    assert (time_value("800ms"), time_value("0.8s")) == (0.8, 0.8)
    for text in ("3uL/min", "3L", "3m/s", "3ml/s/m2", "L/min"):
        with pytest.raises(InputError, match="dL/min"):
            flow_value(text)
    for text in ("0.8", "0.8h", "-1s", "1e9s"):
        with pytest.raises(InputError, match="time"):
            time_value(text)


# Cycles


@pytest.mark.parametrize("cycle", [0.8, 0.42, 60 / 70, 0.852])
@pytest.mark.parametrize("count", [20, 24, 30])
@pytest.mark.parametrize("start", [0.0, 0.37])
def test_rows_without_their_first_repeated_are_a_cycle_of_as_many_steps(read, cycle, count, start):
    time, flow = systole(count + 1, cycle)
    whole = read(time + start, flow)
    assert not whole.cautions
    less, cautions = read(time[:-1] + start, flow[:-1])
    assert less.cycle == pytest.approx(cycle, rel=1e-5)
    assert less.mean == pytest.approx(whole.wave.mean, rel=1e-4)
    assert [one.kind for one in cautions] == ["wave-not-repeated"]
    assert f"{cycle:.4g} s" in str(cautions[0])


def test_rows_that_end_elsewhere_than_they_begin_go_on_where_they_may(read):
    time, flow = systole(21)
    flow = np.roll(flow[:-1], -3)  # begins on its way down
    assert abs(flow[0] - flow[-1]) > 0.05 * np.ptp(flow)
    wave = read(time[:-1], flow).wave
    assert (wave.cycle, wave.mean) == (pytest.approx(0.8), pytest.approx(flow.mean()))
    drift = systole(21)[1] + 40 * time / 0.8
    jump = [1, 2, 3, 4, 9, 10, 11, 40]
    for rows in (
        (time, drift),
        (np.arange(8) * 0.1, jump),
        ([0, 0.1, 0.3, 0.35, 0.8], [0, 9, 5, 2, 3]),
    ):
        with pytest.raises(InputError, match="one that closes"):
            read(*rows)
    # Its length told, it is one.
    assert read(time[:-1], drift[:-1], cycle=0.8).wave.cycle == 0.8


def test_a_cycle_that_is_told_is_taken(read):
    time, flow = systole(21)
    for rows in (20, 18):  # the scanner left out the end of diastole
        wave = read(time[:rows], flow[:rows], cycle=0.8).wave
        assert (wave.cycle, wave.mean) == (0.8, pytest.approx(average(time, flow), rel=1e-6))
    assert read(time, flow, cycle=0.8).wave == read(time, flow).wave
    for cycle in (2.0, 1.7):
        with pytest.raises(InputError, match="rows of a cycle of"):
            read(time, flow, cycle=cycle)


@pytest.mark.parametrize("beats", [2, 3, 5])
def test_several_beats_that_are_alike_are_averaged_and_that_is_said(read, beats):
    rng = np.random.default_rng(beats)
    one = systole(21)[1][:-1]
    flow = np.concatenate([one * rng.uniform(0.97, 1.03) for _ in range(beats)])
    time = np.arange(len(flow)) * 0.04
    for end in (None, flow[0]):
        rows = (time, flow) if end is None else (np.append(time, beats * 0.8), np.append(flow, end))
        wave, cautions = read(*rows)
        assert wave.cycle == pytest.approx(0.8)
        assert wave.mean == pytest.approx(flow.mean(), rel=1e-4)
        assert cautions[-1].kind == "wave-beats"
        assert f"{beats} beats of 0.8 s" in str(cautions[-1])
    # Of others, such as those of a breath, the cycle has to be told.
    flow *= np.repeat(np.linspace(0.6, 1.4, beats), 20)
    wave, cautions = read(time, flow, cycle=0.8)
    assert wave.cycle == pytest.approx(0.8)
    assert wave.mean == pytest.approx(flow.mean(), rel=0.02)
    assert [one.kind for one in cautions] == ["wave-unlike-beats"]
    most, peak = flow.max(), flow.reshape(beats, 20).mean(axis=0).max()
    assert f"whose peak is {peak:.3g} of {most:.3g} mL/s" in str(cautions[0])


def test_a_cycle_that_is_not_that_of_the_beats_is_told_by_what_it_takes(read):
    """Eight beats of 0.7 s, averaged as seven of 0.8 s, kept a quarter of their peak in silence."""
    one = systole(25, cycle=0.7, back=40)[1][:-1]
    time = np.arange(8 * 24) * 0.7 / 24
    right, wrong = (read(time, np.tile(one, 8), cycle=cycle) for cycle in (0.7, 0.8))
    assert [found.kind for found in right.cautions] == ["wave-beats"]
    assert right.wave.peak == pytest.approx(one.max(), rel=1e-3)
    assert [found.kind for found in wrong.cautions] == ["wave-unlike-beats"]
    assert wrong.wave.peak < one.max() / 2
    assert "of 200 mL/s" in str(wrong.cautions[0])


def test_a_cycle_with_two_humps_is_one_beat(read):
    """As in a caval vein."""
    time = np.linspace(0, 0.8, 41)
    flow = 20 + 25 * np.sin(2 * np.pi * time / 0.4) + 12 * np.sin(2 * np.pi * time / 0.8)
    assert read(time, flow).wave.cycle == pytest.approx(0.8)


# What is usual


def test_what_comes_of_a_wrong_unit_is_asked_about():
    time, flow = systole()
    for cycle in (800.0, 0.01, 2.1, 0.23):
        wave = wave_of(time * cycle / 0.8, flow)
        with pytest.raises(InputError, match="30 to 250 beats/min"):
            known_flow(40.0, wave)
        assert known_flow(40.0, wave, unusual=True).wave.rate == pytest.approx(60 / cycle)
    for cycle in (1.99, 0.241):
        assert known_flow(40.0, wave_of(time * cycle / 0.8, flow)).wave
    assert known_flow(446.0).mean == 446
    with pytest.raises(InputError, match=r"26\.8 L/min.*28\.2 L/min"):
        known_flow(470.0)
    assert Known(470.0, unusual=True).mean == 470


# Steps


@pytest.mark.parametrize(
    ("rows", "steps"),
    [
        (systole(21), 100),
        (systole(31), 120),
        (([0, 0.101, 0.106, 0.111, 0.8], [10, 10, 1500, 10, 10]), 800),
        (systole(1501, 1.5), 1500),
    ],
)
def test_every_row_lies_on_a_step_of_the_solver(rows, steps):
    wave = wave_of(*rows)
    assert wave.steps == steps
    assert wave.flow == tuple(rows[1])
    solver = sampled(wave, wave.steps)
    assert solver.max() == pytest.approx(wave.peak, rel=1e-9)
    assert solver.mean() == pytest.approx(wave.mean, rel=1e-9)
    assert Wave(wave.time, wave.flow) == wave


@pytest.mark.parametrize("seed", seeds(5, 60))
def test_rows_at_odd_times_go_to_steps_next_to_them(seed):
    rng = np.random.default_rng([seed, 51])
    time = np.cumsum(rng.uniform(0.013, 0.05, 25))
    time, flow = time - time[0], rng.uniform(-40, 200, 25)
    flow[-1] = flow[0]
    wave = wave_of(time, flow)
    assert wave.steps == 1000
    assert np.abs(np.array(wave.time) - time).max() <= time[-1] / 2000 * (1 + 1e-9)
    assert wave.mean == pytest.approx(average(time, flow), rel=1e-6)
    assert wave.flow == pytest.approx(flow, abs=0.02 * np.ptp(flow))
    assert sampled(wave, 1000).max() == pytest.approx(wave.peak)
    again = Wave(wave.time, wave.flow)
    assert again == wave


def test_rows_closer_than_steps_are_averaged_and_a_faster_spike_is_refused():
    time, flow = systole(5003, 0.8137)
    wave = wave_of(time, flow)
    assert wave.steps == 1000
    assert (wave.mean, wave.peak) == (
        pytest.approx(average(time, flow)),
        pytest.approx(200, rel=2e-3),
    )
    with pytest.raises(InputError, match="jumps by 133 mL/s"):
        wave_of([0, 0.20001, 0.20013, 0.2003, 0.8], [0, 0, 100, 0, 0])


# Means over a cycle


@pytest.mark.parametrize("seed", seeds(10, 100))
def test_flows_that_stand_for_a_wave_tell_its_means(seed):
    rng = np.random.default_rng([seed, 52])
    count = int(rng.integers(4, 40))
    flow = rng.uniform(-60, 200, count) * (rng.random(count) < rng.choice([0.4, 1.0]))
    flow[-1], flow[1] = flow[0], 150.0
    time = np.linspace(0, 0.8, count)
    if average(time, flow) < 1:
        flow = flow - flow.min()
    flows, weights = wave_of(time, flow).spread()
    assert weights.sum() == pytest.approx(1, rel=1e-12)
    assert (weights > 0).all()
    assert len(flows) <= 17
    for what in (
        lambda q: q,
        lambda q: 0.3 * q + 0.02 * q * abs(q),
        lambda q: abs(q) ** 1.8 * np.sign(q),
        lambda q: (q > 0) * q,
    ):
        scale = abs(what(flow)).max()
        assert weights @ what(flows) == pytest.approx(average(time, flow, what), abs=2e-5 * scale)


def test_the_regurgitant_fraction_is_what_runs_back():
    for back in (0.0, 20.0, 60.0):
        time, flow = systole(81, back=back)
        forward = average(time, flow, lambda q: np.maximum(q, 0))
        wave = wave_of(time, flow)
        assert wave.back == pytest.approx(1 - average(time, flow) / forward, abs=1e-6)


# Flow that runs back


def tube(depth=0.5, middle=50.0):
    """Of 10 mm with a raised cosine, the same from both sides."""
    x = np.linspace(0, 100, 401)
    size = 10 * (1 - depth / 2 * (1 + np.cos(np.pi * np.clip((x - middle) / 8, -1, 1))))
    line = np.column_stack([0 * x, 0 * x, x])
    return Channel(line, x, size, size, np.zeros(401, dtype=np.int64), x, -1)


@pytest.mark.parametrize("seed", seeds(5, 50))
def test_what_runs_back_costs_as_much_with_the_other_sign(seed):
    rng = np.random.default_rng([seed, 53])
    one = tube(rng.uniform(0, 0.7))
    widths = Widths(one.inscribed, one.inscribed)
    stream = Stream(np.array([12e-6]), np.zeros(1), np.zeros(401))
    network = Network(
        blocks_of([one], (widths,), stream), tree_between(np.array([[0, 1]]), {0: 1.0})
    )
    start, end = np.sort(rng.uniform(0, 400, 2)).tolist()
    for flow in rng.uniform(0, 2e-4, 5):
        there, back = (
            drop_over([BlockPart(0, start, end)], network, np.array([q])) for q in (flow, -flow)
        )
        assert back == pytest.approx([-x for x in there], rel=1e-9, abs=1e-9)
        assert there.maximal >= there.recovered >= 0


def test_the_drop_over_a_regurgitant_wave_is_that_of_its_moments():
    """a Q + b Q |Q| by what is told at peaks beside the same mean flow."""
    one, line = tube(), tube().points[150:251]
    pressures = {"inlet": 30.0, "wedge": 8.0}

    def told(moment, *given, **more):
        model = FlowModel([one], known_flow(12.0, *given, **pressures, **more))
        return model.answer(None, [Part("", line)]).before[moment].drops[0]

    peaks = np.array([15, 30, 45, 60, 75.0])
    for kind in ("recovered", "maximal"):
        drops = [getattr(told("peak", peak=peak), kind).value for peak in peaks.tolist()]
        terms = np.column_stack([peaks, peaks**2])
        (a, b), *_ = np.linalg.lstsq(terms, np.array(drops), rcond=None)
        time, flow = systole(81, back=60)
        wave = wave_of(time, flow)
        flow = flow * 12 / wave.mean
        right = average(time, flow, lambda q, a=a, b=b: a * q + b * q * abs(q))
        band = getattr(told("mean", wave), kind)
        assert band.value == pytest.approx(right, rel=1e-3)
        assert band.low < band.value < band.high
        forward = average(
            time, flow, lambda q, a=a, b=b: np.maximum(a * q + b * q * q, 0) * (q > 0)
        )
        assert band.value < forward


# What the patient is known by


def inlet_over(network, outlets, wave):
    """Mean pressure at the inlet, mmHg, of so many steady flows."""
    flows = 1e-6 * sampled(wave, 400)
    return np.mean([steady(network, outlets, float(q)).inlet for q in flows]) / MMHG


@pytest.mark.parametrize("split", [None, 0.3, 0.7])
def test_pressures_that_outlets_can_meet_are_met_and_others_name_the_cost(a_fork, split):
    channels, right = a_fork
    wave = wave_of(*systole(back=60)).scaled(40.0)
    model = FlowModel(channels, known_flow(40.0, wave, split_right=split, right=right))
    network = model.answer().networks[0]

    def fitted(inlet):
        known = known_flow(40.0, wave, inlet=inlet, wedge=10.0, split_right=split, right=right)
        return FlowModel(channels, known).answer()

    with pytest.raises(InputError, match=r"a wave of 40 mL/s.* cost about (\d+\.\d) mmHg") as error:
        fitted(12.0)
    cost = float(str(error.value).split("cost about ")[1].split()[0])
    if split is None:  # outlets that resist nothing, by hand
        least = Outlets(np.full(2, 1.0), 10 * MMHG)
        assert cost == pytest.approx(inlet_over(network, least, wave) - 10, abs=0.2)
        assert cost == pytest.approx(16.6, abs=0.2)
    with pytest.raises(InputError, match="cost about"):
        fitted(10 + cost - 0.3)
    for inlet in (10 + cost + 0.3, 10 + cost + 3, 60.0):
        answer = fitted(inlet)
        moment = answer.before["mean"]
        assert moment.inlet.value == pytest.approx(inlet, rel=1e-5)
        assert inlet_over(answer.networks[0], answer.outlets, wave) == pytest.approx(
            inlet, rel=3e-3
        )
        if split:
            assert moment.sides[1].value == pytest.approx(split, abs=1e-5)
        # What the pressures do not leave room for is in no range.
        assert moment.inlet.low == pytest.approx(inlet, rel=1e-5)
        assert moment.inlet.high == pytest.approx(inlet, rel=1e-5)


def test_a_steady_flow_whose_share_costs_too_much_takes_another_way(a_fork):
    """Outlets of the same size, one behind a narrowing: as much flow to both costs more than there
    is, but less goes there."""
    channels, right = a_fork
    below = [k for k, one in enumerate(channels) if one.above == 0]
    tight = channels[below[0]]
    size = np.where(np.arange(len(tight.along)) < len(tight.along) - 4, 2.2, tight.inscribed)
    tight = tight._replace(inscribed=size, section=size)
    tree = [tight if k == below[0] else one for k, one in enumerate(channels)]
    known = known_flow(40.0, inlet=22.0, wedge=10.0)
    answer = FlowModel(tree, known).answer()
    assert answer.before["mean"].inlet.value == pytest.approx(22.0, rel=1e-5)
    with pytest.raises(InputError, match="with 50 % to the right cost about"):
        FlowModel(tree, known_flow(40.0, inlet=22.0, wedge=10.0, split_right=0.5, right=right))


# Everything at once


@pytest.fixture(scope="module")
def vessels(a_fork):
    narrow = stenosed_tube(edge_length=1.2)
    tree = vascular_tree(8, 0.8, {1: 0.5, 4: 0.6, 8: 0.4})
    return [
        [tube(0.5)],
        a_fork[0],
        channels_of(narrow.surface, narrow.centerline),
        channels_of(tree.surface, tree.centerline),
    ]


def random_rows(rng):
    """Times and flows of a cycle: even or not, late or not, with standstill and backflow."""
    count, cycle = int(rng.integers(5, 41)), rng.uniform(0.3, 1.6)
    time = np.linspace(0, cycle, count)
    if rng.random() < 0.5:
        time[1:-1] += rng.uniform(-0.3, 0.3, count - 2) * cycle / (count - 1)
    part = time / cycle
    end = rng.uniform(0.25, 0.6)
    flow = rng.uniform(0, 20) * (rng.random() < 0.3) + np.where(
        part < end, np.sin(np.pi * part / end) * 100, 0.0
    )
    if rng.random() < 0.5:
        flow -= np.where(
            part > end, rng.uniform(0, 70) * np.sin(np.pi * (part - end) / (1 - end)), 0
        )
    flow[-1] = flow[0]
    if average(time, flow) < 2:
        flow = np.abs(flow)
    return time + rng.choice([0.0, rng.uniform(-0.2, 0.9)]), flow * rng.uniform(0.1, 3)


def numbers_of(answer):
    for moment in answer.before.values():
        bands = [*filter(None, [moment.inlet]), *(moment.sides or ())]
        bands += [band for drop in moment.drops for band in drop]
        for band in bands:
            assert np.isfinite(band).all()
            assert band.low <= band.value + 1e-9
            assert band.value <= band.high + 1e-9


@pytest.mark.parametrize("seed", seeds(8, 300))
def test_any_wave_is_answered_or_refused_in_a_sentence(vessels, read, seed):
    pytest.importorskip("svzerod")
    rng = np.random.default_rng([seed, 51])
    channels = vessels[seed % len(vessels)]
    time, flow = random_rows(rng)
    if len(channels) == 1 and channels[0].inscribed.min() < 5:
        flow *= 0.1
    wave, cautions = read(time, flow)
    if cautions:  # by chance the cycle would be rounder with one more step
        wave, cautions = read(time, flow, cycle=np.ptp(time))
    assert not cautions
    assert wave.mean == pytest.approx(average(time, flow), rel=2e-3, abs=1e-3 * np.ptp(flow))
    pressures = {}
    if rng.random() < 0.6:
        wedge = rng.uniform(0, 15)
        pressures = {"inlet": wedge + rng.uniform(2, 60), "wedge": wedge}
    known = known_flow(wave.mean, wave, **pressures)
    line = channels[0].points
    parts = [Part("first", line), Part("some", line[len(line) // 4 : -len(line) // 4])]
    try:
        model = FlowModel(channels, known)
    except InputError as error:
        assert "a wave of" in str(error)  # noqa: PT017
        return
    for solve in (None, solved_by_svzerod):
        answer = model.answer(None, parts, solve)
        numbers_of(answer)
        for moment in answer.before.values():
            if moment.sides:
                lead = [one.value for one in moment.sides]
                assert sum(lead) <= 1 + 1e-6
                assert sum(lead) == pytest.approx(1, abs=1e-6) or len(channels) > 3
    if pressures:
        told = answer.before["mean"].inlet.value
        assert told == pytest.approx(known.inlet, rel=0.01, abs=0.05)
        svzerod = pytest.importorskip("svzerod")
        table = svzerod.simulate(svzerod_document(answer.networks[0], answer.outlets, known))
        inlet = table[table.name == "vessel0"]
        mean = np.trapezoid(inlet.pressure_in, inlet.time) / np.ptp(inlet.time) / (10 * MMHG)
        assert mean == pytest.approx(told, abs=1e-3)
        # And what flows in is what is told.
        assert inlet.flow_in.max() == pytest.approx(answer.flows["peak"], rel=1e-3)
        assert np.trapezoid(inlet.flow_in, inlet.time) / np.ptp(inlet.time) == pytest.approx(
            answer.flows["mean"], rel=1e-4, abs=1e-4 * known.most
        )
