"""The endpoint that Prometheus scrapes: figures are read from the interface memory when they are asked for.

collector = MachineCollector(hli, statistics)
server = start_metrics_server("127.0.0.1", 9402, collector)   # http://127.0.0.1:9402/metrics
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from wsgiref.simple_server import WSGIServer

from prometheus_client import CollectorRegistry, start_http_server
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily
from prometheus_client.core import Metric as Family
from prometheus_client.registry import Collector

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Severity, TandemError
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.layout import Hli
from runtime.monitoring.metrics import METRICS, CycleReading, HistogramReading, Kind, Metric, RecorderReading, Source


class MetricsError(TandemError):
    """The endpoint cannot be opened."""


class MachineCollector(Collector):
    """Reads the table of metrics for every scrape.

    `hli` is the interface memory (runtime.hli.layout), `cycle` the statistics of the cycle. Errors are counted from the
    events, which are those of this run: the alarm list of the interface begins with those of earlier runs.
    """

    def __init__(self, hli: Hli, cycle: CycleReading, recorder: RecorderReading | None = None) -> None:
        self._errors: dict[tuple[str, str], int] = {}
        self._source = Source(hli, cycle, self._errors, recorder)
        self._lock = threading.Lock()  # scrapes have a thread each

    def count(self, event: Event) -> None:
        """Take note of an event: `number` is the id, `value` the severity of an error; others count nothing."""
        if event.kind is not EventKind.ERROR:
            return
        severity = int(event.value)
        name = Severity(severity).name.lower() if severity in set(Severity) else "unknown"
        with self._lock:
            self._errors[str(event.number), name] = self._errors.get((str(event.number), name), 0) + 1

    def collect(self) -> Iterator[Family]:
        """All metrics, now."""
        with self._lock:
            families = [_family(metric, self._source) for metric in METRICS]
        yield from families

    def describe(self) -> Iterator[Family]:
        """Names only: registering reads nothing."""
        return (Family(metric.name.removesuffix("_total"), metric.help, metric.kind.value) for metric in METRICS)


def _family(metric: Metric, source: Source) -> Family:
    if metric.kind is Kind.HISTOGRAM:
        assert metric.histogram is not None
        return _histogram(metric, metric.histogram(source))
    assert metric.read is not None
    kind = CounterMetricFamily if metric.kind is Kind.COUNTER else GaugeMetricFamily
    family = kind(metric.name, metric.help, labels=metric.labels)
    for labels, value in metric.read(source):
        family.add_metric(labels, float(value))
    return family


def _histogram(metric: Metric, reading: HistogramReading) -> Family:
    """Prometheus counts into each bucket everything up to its bound."""
    buckets: list[tuple[str, float]] = []
    counted = 0
    for bound, count in zip((*reading.bounds, math.inf), reading.counts, strict=True):
        counted += count
        buckets.append(("+Inf" if math.isinf(bound) else repr(bound), counted))
    family = HistogramMetricFamily(metric.name, metric.help)
    family.add_metric([], buckets=buckets, sum_value=reading.sum)
    return family


class MetricsServer:
    """A running endpoint; `port` is the one it really has, also when 0 was asked for."""

    def __init__(self, server: WSGIServer, thread: threading.Thread) -> None:
        self._server = server
        self._thread = thread
        self.port = int(server.server_port)

    def close(self) -> None:
        """End the endpoint and give its port back."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def start_metrics_server(host: str, port: int, collector: MachineCollector) -> MetricsServer:
    """Serve `http://host:port/metrics` from a thread; `port` 0 takes any free one. Raises MetricsError."""
    registry = CollectorRegistry()
    registry.register(collector)
    try:
        server, thread = start_http_server(port, host, registry)
    except OSError as error:
        reason = error.strerror or str(error)
        raise MetricsError(system.METRICS_PORT, host=host, port=port, reason=reason) from error
    return MetricsServer(server, thread)
