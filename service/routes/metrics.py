"""Metrics for monitoring: counts of studies, points and requests, and the state of the cluster, as Prometheus text."""

from collections.abc import Iterable, Mapping

from fastapi import Request
from fastapi.responses import PlainTextResponse

from damperlab.service.own_process import own_process
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService
from damperlab.service.traffic import BOUNDS, Durations, Traffic
from damperlab.studies.vocabulary import ENDED, STATES
from damperlab.worker.provenance import code_version

FORMAT = "text/plain; version=0.0.4; charset=utf-8"
"""Version of the exposition format, https://prometheus.io/docs/instrumenting/exposition_formats."""

router = strict_router(tag="health")

Labels = Mapping[str, object]


@router.get(
    "/metrics",
    response_class=PlainTextResponse,
    summary="Metrics for monitoring, in the text format of Prometheus",
)
def ask_metrics(service: TheService, request: Request) -> PlainTextResponse:
    """Give the numbers of studies, points and requests, the request times, and the load of process and cluster."""
    from damperlab.worker.kernel_cache import source_hash  # imported late: the import loads the compiler

    totals = service.store.totals()
    traffic: Traffic = request.app.state.traffic
    counts, durations = traffic.read()
    lines: list[str] = []
    _tell(
        lines, "info", "gauge", "Version of the code, hash of the solver's sources.",
        [({"version": code_version(), "solver": source_hash()}, 1)],
    )  # fmt: skip
    _tell(
        lines, "studies", "gauge", "Stored studies, by state.",
        [({"state": state}, totals[state].studies if state in totals else 0) for state in STATES],
    )  # fmt: skip
    for name, meaning in (
        ("points", "Design points of the stored studies."),
        ("points_done", "Design points that are stored."),
        ("points_failed", "Design points stored as failed."),
        ("bytes", "Bytes of the cubes at full size."),
    ):
        _tell(lines, name, "gauge", meaning, [({}, sum(getattr(one, name) for one in totals.values()))])
    _tell(
        lines,
        "studies_running_here",
        "gauge",
        "Studies that this process runs.",
        [({}, len(service.dispatcher.running))],
    )
    _tell(
        lines,
        "blocks_left",
        "gauge",
        "Blocks that waiting and running studies, here or elsewhere, have not computed yet.",
        [({}, sum(one.blocks_left for state, one in totals.items() if state not in ENDED))],
    )
    workers, in_flight, retries = service.dispatcher.workload()
    _tell(
        lines,
        "workers",
        "gauge",
        "Workers of the cluster, by their state in the studies that run here.",
        [({"standing": standing}, count) for standing, count in workers.items()],
    )
    _tell(lines, "blocks_in_flight", "gauge", "Blocks at workers.", [({}, in_flight)])
    _tell(lines, "block_retries_total", "counter", "Blocks that were started again.", [({}, retries)])
    trouble = service.dispatcher.trouble is not None
    _tell(
        lines,
        "cluster_trouble",
        "gauge",
        "1 while the cluster or the store cannot be used.",
        [({}, int(trouble))],
    )
    threads = (*service.backgrounds, service.readiness.background)
    _tell(
        lines,
        "background_down",
        "gauge",
        "1 while a background thread cannot do its work.",
        [({"thread": each.name}, int(each.trouble is not None)) for each in threads],
    )
    _tell(
        lines,
        "background_failures_total",
        "counter",
        "Failures of background threads, which were restarted.",
        [({"thread": each.name}, each.failures) for each in threads],
    )
    _tell(
        lines, "requests_total", "counter", "Requests answered; status 0 if the client left before the answer.",
        [({"method": method, "status": status}, count) for (method, status), count in sorted(counts.items())],
    )  # fmt: skip
    _tell(
        lines, "request_seconds_total", "counter", "Total time of the answered requests.",
        [({}, sum(each.seconds for each in durations.values()))],
    )  # fmt: skip
    _tell_durations(lines, durations)
    compiled, seconds = service.kernels.compiled()
    _tell(
        lines,
        "scenes_compiled_total",
        "counter",
        "Scenes whose kernels were compiled at the request of this process.",
        [({}, compiled)],
    )
    _tell(
        lines,
        "compile_seconds_total",
        "counter",
        "Time of these compilations; the times of parallel compilations are added up.",
        [({}, seconds)],
    )
    for name, (kind, meaning, value) in own_process().items():
        _tell(lines, name, kind, meaning, [({}, value)], prefix="")
    return PlainTextResponse("\n".join(lines) + "\n", media_type=FORMAT)


def _tell_durations(lines: list[str], durations: Mapping[tuple[str, str], Durations]) -> None:
    """Write a histogram of request times for each method and route. Routes contain placeholders for parameters."""
    name = "damperlab_request_duration_seconds"
    lines += [f"# HELP {name} Time until an answer was complete, by route.", f"# TYPE {name} histogram"]
    for (method, route), each in sorted(durations.items()):
        labels = f'method="{method}",route="{route}"'
        for bound, count in zip((*map(str, BOUNDS), "+Inf"), each.within, strict=True):
            lines.append(f'{name}_bucket{{{labels},le="{bound}"}} {count}')
        lines += [f"{name}_sum{{{labels}}} {each.seconds}", f"{name}_count{{{labels}}} {each.within[-1]}"]


def _tell(
    lines: list[str],
    name: str,
    kind: str,
    meaning: str,
    samples: Iterable[tuple[Labels, float]],
    prefix: str = "damperlab_",
) -> None:
    full = f"{prefix}{name}"
    lines += [f"# HELP {full} {meaning}", f"# TYPE {full} {kind}"]
    for labels, value in samples:
        inside = ",".join(f'{key}="{label}"' for key, label in labels.items())
        lines.append(f"{full}{{{inside}}} {value}" if inside else f"{full} {value}")
