"""The metrics endpoint: scraped over HTTP from an interface memory with known contents."""

from __future__ import annotations

import http.client
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from runtime.diagnostics.errors import Severity
from runtime.diagnostics.events import Event, EventKind
from runtime.drives import DriveState
from runtime.hli.layout import Hli, Mode, State, StopCondition
from runtime.monitoring.endpoint import MachineCollector, MetricsError, MetricsServer, start_metrics_server
from runtime.monitoring.metrics import METRICS, Kind
from runtime.recorder.drain import RecorderFigures
from runtime.scheduler.statistics import CycleStatistics

Scrape = dict[tuple[str, frozenset[tuple[str, str]]], float]


def machine() -> Hli:
    """A machine at work: X linear, S spindle, one channel that waits for an M function."""
    hli = Hli()
    hli.head.running_r = True
    hli.head.version_r = b"1"
    hli.head.cycle_time_r = 1000
    hli.head.channels_r = 1
    hli.head.axes_r = 2
    hli.head.cycle_r = 123_456
    hli.platform.overruns_r = 3
    hli.platform.plc_running_r = True
    hli.platform.plc_cycle_time_ns_w = 250_000
    hli.platform.plc_overruns_r = 2
    hli.platform.bus_count_r = 2
    for bus, channel, load in zip(hli.platform.bus_r, (b"can0", b"can1"), (0.375, 0.0), strict=False):
        bus.channel_r, bus.load_r, bus.gone_r = channel, load, not load
    hli.platform.emcy_count_r = 4
    hli.platform.frames_sent_r = 1000
    hli.platform.frames_received_r = 2000
    x, s = hli.axes[0], hli.axes[1]
    x.name_r, x.axis_type_r = b"X", 1
    x.status.actual_position_r = 1_234_567  # 0.1 µm
    x.status.position_lag_r = -50
    x.status.actual_velocity_r = 400_000
    x.status.drive_state_r = DriveState.OPERATION_ENABLED
    s.name_r, s.axis_type_r = b"S", 4
    s.status.actual_position_r = 900_000  # 0.0001 degrees
    s.status.actual_velocity_r = 36_000_000
    s.status.drive_state_r = DriveState.FAULT
    s.error_r = True
    channel = hli.channels[0]
    channel.name_r = "fräse".encode()
    channel.control.mode_and_state.mode_r = Mode.AUTOMATIC
    channel.control.mode_and_state.state_r = State.ACTIVE
    channel.status.stop_condition_r = StopCondition.WAIT_TECHNOLOGY | StopCondition.FEED_HOLD
    channel.status.line_r = 42
    channel.status.active_override_r = 850
    channel.status.active_feed_r = 16_667
    channel.status.waiting_functions_r = 1
    channel.status.prepared_blocks_r = 57
    channel.status.block_counter_r = 99
    return hli


def error(number: int, severity: Severity) -> Event:
    return Event(1.0, 1000, EventKind.ERROR, number=number, value=float(severity), text="Drive: fault")


@pytest.fixture
def hli() -> Hli:
    return machine()


@pytest.fixture
def statistics() -> CycleStatistics:
    return CycleStatistics()


@pytest.fixture
def collector(hli: Hli, statistics: CycleStatistics) -> MachineCollector:
    return MachineCollector(
        hli, statistics, RecorderFigures(bytes=4096, records=9, dropped=2, lost=1, saved=3, writing=True)
    )


@pytest.fixture
def server(collector: MachineCollector) -> Iterator[MetricsServer]:
    running = start_metrics_server("127.0.0.1", 0, collector)
    yield running
    running.close()


def scrape(server: MetricsServer) -> Scrape:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.request("GET", "/metrics")
    response = connection.getresponse()
    assert response.status == 200
    text = response.read().decode()
    connection.close()
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def value(found: Scrape, name: str, **labels: str) -> float:
    return found[name, frozenset(labels.items())]


def test_the_figures_arrive_in_base_units(server: MetricsServer) -> None:
    found = scrape(server)
    assert value(found, "tandem_running") == 1
    assert value(found, "tandem_cycle_period_seconds") == 0.001
    assert value(found, "tandem_cycles_total") == 123_456
    assert value(found, "tandem_cycle_overruns_total") == 3
    assert value(found, "tandem_plc_running") == 1
    assert value(found, "tandem_plc_cycle_seconds") == 0.00025
    assert value(found, "tandem_plc_overruns_total") == 2
    assert value(found, "tandem_can_load_ratio", channel="can0") == 0.375
    assert [value(found, "tandem_can_bus_gone", channel=channel) for channel in ("can0", "can1")] == [0, 1]
    assert value(found, "tandem_can_frames_total", direction="sent") == 1000
    assert value(found, "tandem_can_frames_total", direction="received") == 2000
    assert value(found, "tandem_can_emcy_total") == 4
    assert value(found, "tandem_recorder_bytes") == 4096
    assert value(found, "tandem_recorder_records_total") == 9
    assert value(found, "tandem_recorder_dropped_total", at="ring") == 2
    assert value(found, "tandem_recorder_dropped_total", at="disk") == 1
    assert value(found, "tandem_recorder_saved_total") == 3
    assert value(found, "tandem_recorder_writing") == 1
    assert value(found, "tandem_axis_position_meters", axis="X") == pytest.approx(0.1234567)
    assert value(found, "tandem_axis_following_error_meters", axis="X") == pytest.approx(-5e-6)
    assert value(found, "tandem_axis_velocity_meters_per_second", axis="X") == pytest.approx(0.4)
    assert value(found, "tandem_axis_position_degrees", axis="S") == pytest.approx(90.0)
    assert value(found, "tandem_axis_velocity_degrees_per_second", axis="S") == pytest.approx(36_000.0)
    assert value(found, "tandem_axis_error", axis="S") == 1
    assert value(found, "tandem_channel_active_line", channel="fräse") == 42
    assert value(found, "tandem_channel_override_ratio", channel="fräse") == 0.85
    assert value(found, "tandem_channel_feed_meters_per_second", channel="fräse") == pytest.approx(0.016667)
    assert value(found, "tandem_channel_functions_waiting", channel="fräse") == 1
    assert value(found, "tandem_channel_prepared_blocks", channel="fräse") == 57
    assert value(found, "tandem_channel_blocks_total", channel="fräse") == 99


def test_no_series_mixes_units(server: MetricsServer) -> None:
    axes = {(name, dict(labels).get("axis")) for name, labels in scrape(server)}
    assert ("tandem_axis_position_meters", "S") not in axes
    assert ("tandem_axis_position_degrees", "X") not in axes


@pytest.mark.parametrize(
    ("name", "label", "owner", "holds"),
    [
        ("tandem_axis_drive_state", "state", {"axis": "X"}, {"operation_enabled"}),
        ("tandem_axis_drive_state", "state", {"axis": "S"}, {"fault"}),
        ("tandem_channel_mode", "mode", {"channel": "fräse"}, {"automatic"}),
        ("tandem_channel_state", "state", {"channel": "fräse"}, {"active"}),
        ("tandem_channel_stop_condition", "condition", {"channel": "fräse"}, {"wait_technology", "feed_hold"}),
    ],
)
def test_a_state_is_one_gauge_per_possible_state(
    server: MetricsServer, name: str, label: str, owner: dict[str, str], holds: set[str]
) -> None:
    states = {
        dict(labels)[label]: number
        for (found, labels), number in scrape(server).items()
        if found == name and owner.items() <= dict(labels).items()
    }
    assert {state for state, number in states.items() if number == 1} == holds
    assert set(states.values()) == {0.0, 1.0}


def test_histograms_count_up_to_each_bound(server: MetricsServer, statistics: CycleStatistics) -> None:
    for microseconds in (90, 100, 180, 10**6):
        statistics.work.add(microseconds * 1000)
    found = scrape(server)
    assert value(found, "tandem_cycle_work_seconds_bucket", le="7e-05") == 0
    assert value(found, "tandem_cycle_work_seconds_bucket", le="0.0001") == 2
    assert value(found, "tandem_cycle_work_seconds_bucket", le="0.0002") == 3
    assert value(found, "tandem_cycle_work_seconds_bucket", le="+Inf") == 4
    assert value(found, "tandem_cycle_work_seconds_count") == 4
    assert value(found, "tandem_cycle_work_seconds_sum") == pytest.approx(1.00037)
    assert value(found, "tandem_cycle_lateness_seconds_count") == 0


def test_errors_are_counted_by_id_and_severity(server: MetricsServer, collector: MachineCollector) -> None:
    for event in (
        error(303_010, Severity.ERROR),
        error(303_010, Severity.ERROR),
        error(305_010, Severity.WARNING),
        Event(1.0, 1000, EventKind.M_OUT, number=8, value=2.0),
    ):
        collector.count(event)
    assert value(scrape(server), "tandem_errors_total", id="303010", severity="error") == 2
    collector.count(error(303_010, Severity.ERROR))
    found = scrape(server)
    assert {
        (dict(labels)["id"], dict(labels)["severity"]): number
        for (name, labels), number in found.items()
        if name == "tandem_errors_total"
    } == {("303010", "error"): 3, ("305010", "warning"): 1}


def test_alarms_of_earlier_runs_are_not_counted(server: MetricsServer, hli: Hli) -> None:
    hli.alarms[0].id_r, hli.alarm_count_r = 303_010, 1  # restored into the history
    assert not any(name == "tandem_errors_total" for name, _ in scrape(server))


def test_every_metric_of_the_table_is_exported_and_named_by_the_conventions(
    server: MetricsServer, collector: MachineCollector
) -> None:
    collector.count(error(1, Severity.ERROR))
    names = {re.sub(r"_(bucket|sum|count)$", "", name) for name, _ in scrape(server)}
    for metric in METRICS:
        assert metric.name in names, metric.name
        assert re.fullmatch(r"tandem(_[a-z]+)+", metric.name)
        assert metric.name.endswith("_total") == (metric.kind is Kind.COUNTER)
        assert metric.help.endswith(".")
        assert not re.search(r"_(milli|micro|percent|minutes|mm|ms|us)(_|$)", metric.name)
    assert len({metric.name for metric in METRICS}) == len(METRICS)


def test_a_port_that_is_taken_is_an_error_of_the_catalogue(server: MetricsServer, collector: MachineCollector) -> None:
    with pytest.raises(MetricsError) as caught:
        start_metrics_server("127.0.0.1", server.port, collector)
    assert caught.value.problem.entry.id == 305030
    assert str(server.port) in caught.value.problem.text


def test_a_closed_endpoint_gives_its_port_back(collector: MachineCollector) -> None:
    first = start_metrics_server("127.0.0.1", 0, collector)
    first.close()
    second = start_metrics_server("127.0.0.1", first.port, collector)
    assert scrape(second)
    second.close()


def test_the_dashboard_uses_metrics_and_labels_that_exist() -> None:
    dashboard = json.loads(Path("config/grafana-dashboard.json").read_text(encoding="utf-8"))
    known: dict[str, set[str]] = {}
    for metric in METRICS:
        if metric.kind is Kind.HISTOGRAM:
            known |= {f"{metric.name}_bucket": {"le"}, f"{metric.name}_sum": set(), f"{metric.name}_count": set()}
        else:
            known[metric.name] = set(metric.labels)
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel.get("targets", [])]
    expressions += [variable["query"] for variable in dashboard["templating"]["list"] if variable["type"] == "query"]
    used: set[str] = set()
    for expression in expressions:
        for name, matchers in re.findall(r"(tandem_\w+)(?:\{([^}]*)\})?", expression):
            used.add(name)
            assert name in known, expression
            labels = set(re.findall(r"(\w+)\s*(?:=~|!~|!=|=)", matchers)) - {"instance", "job"}
            assert labels <= known[name], expression
    unused = {metric.name for metric in METRICS} - {re.sub(r"_(bucket|sum|count)$", "", name) for name in used}
    assert unused <= {"tandem_axis_position_degrees", "tandem_axis_following_error_degrees", "tandem_axis_error"}
    ids = [panel["id"] for panel in dashboard["panels"]]
    assert len(ids) == len(set(ids))
