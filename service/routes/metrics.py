"""Metrics for monitoring: counts of studies, points and requests, and the state of the cluster, as Prometheus text."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from fastapi import Request
from fastapi.responses import PlainTextResponse

from damperlab.service.own_process import own_process
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService
from damperlab.service.traffic import BOUNDS, Durations
from damperlab.studies.vocabulary import ENDED, STATES
from damperlab.worker.provenance import code_version

FORMAT = "text/plain; version=0.0.4; charset=utf-8"
"""Version of the exposition format, https://prometheus.io/docs/instrumenting/exposition_formats."""

router = strict_router(tag="health")

Samples = Sequence[tuple[Mapping[str, object], float]]
Metric = tuple[str, str, str, float | Samples]
"""Name without prefix, kind, meaning, and the value or, if the metric has labels, its values."""


@router.get(
    "/metrics",
    response_class=PlainTextResponse,
    summary="Metrics for monitoring, in the text format of Prometheus",
)
def ask_metrics(service: TheService, request: Request) -> PlainTextResponse:
    """Give the numbers of studies, points and requests, the request times, and the load of process and cluster."""
    counts, durations = request.app.state.traffic.read()
    lines = [
        *_written(_stored(service)),
        *_written(_running(service)),
        *_written(_answered(counts, durations)),
        *_durations(durations),
        *_written(_compiled(service)),
    ]
    for name, (kind, meaning, value) in own_process().items():
        lines += _family(name, kind, meaning, [({}, value)])
    return PlainTextResponse("\n".join(lines) + "\n", media_type=FORMAT)


def _stored(service: TheService) -> Iterator[Metric]:
    from damperlab.worker.kernel_cache import source_hash  # imported late: the import loads the compiler

    totals = service.store.totals()
    versions = {"version": code_version(), "solver": source_hash()}
    yield "info", "gauge", "Version of the code, hash of the solver's sources.", [(versions, 1)]
    studies = [({"state": state}, totals[state].studies if state in totals else 0) for state in STATES]
    yield "studies", "gauge", "Stored studies, by state.", studies
    for name, meaning in (
        ("points", "Design points of the stored studies."),
        ("points_done", "Design points that are stored."),
        ("points_failed", "Design points stored as failed."),
        ("bytes", "Bytes of the cubes at full size."),
    ):
        yield name, "gauge", meaning, sum(getattr(one, name) for one in totals.values())
    left = sum(one.blocks_left for state, one in totals.items() if state not in ENDED)
    meaning = "Blocks that waiting and running studies, here or elsewhere, have not computed yet."
    yield "blocks_left", "gauge", meaning, left


def _running(service: TheService) -> Iterator[Metric]:
    dispatcher = service.dispatcher
    yield "studies_running_here", "gauge", "Studies that this process runs.", len(dispatcher.running)
    workers, in_flight, retries = dispatcher.workload()
    standings = [({"standing": standing}, count) for standing, count in workers.items()]
    yield (
        "workers",
        "gauge",
        "Workers of the cluster, by their state in the studies that run here.",
        standings,
    )
    yield "blocks_in_flight", "gauge", "Blocks at workers.", in_flight
    yield "block_retries_total", "counter", "Blocks that were started again.", retries
    trouble = int(dispatcher.trouble is not None)
    yield "cluster_trouble", "gauge", "1 while the cluster or the store cannot be used.", trouble
    threads = (*service.backgrounds, service.readiness.background)
    down = [({"thread": each.name}, int(each.trouble is not None)) for each in threads]
    yield "background_down", "gauge", "1 while a background thread cannot do its work.", down
    failures = [({"thread": each.name}, each.failures) for each in threads]
    meaning = "Failures of background threads, which were restarted."
    yield "background_failures_total", "counter", meaning, failures


def _answered(
    counts: Mapping[tuple[str, int], int], durations: Mapping[tuple[str, str], Durations]
) -> Iterator[Metric]:
    answers = [
        ({"method": method, "status": status}, count) for (method, status), count in sorted(counts.items())
    ]
    meaning = "Requests answered; status 0 if the client left before the answer."
    yield "requests_total", "counter", meaning, answers
    seconds = sum(each.seconds for each in durations.values())
    yield "request_seconds_total", "counter", "Total time of the answered requests.", seconds


def _compiled(service: TheService) -> Iterator[Metric]:
    compiled, seconds = service.kernels.compiled()
    meaning = "Scenes whose kernels were compiled at the request of this process."
    yield "scenes_compiled_total", "counter", meaning, compiled
    meaning = "Time of these compilations; the times of parallel compilations are added up."
    yield "compile_seconds_total", "counter", meaning, seconds


def _written(metrics: Iterable[Metric]) -> Iterator[str]:
    for name, kind, meaning, found in metrics:
        yield from _family(
            f"damperlab_{name}", kind, meaning, [({}, found)] if isinstance(found, int | float) else found
        )


def _family(name: str, kind: str, meaning: str, samples: Samples) -> Iterator[str]:
    yield f"# HELP {name} {meaning}"
    yield f"# TYPE {name} {kind}"
    for labels, value in samples:
        inside = ",".join(f'{key}="{label}"' for key, label in labels.items())
        yield f"{name}{{{inside}}} {value}" if inside else f"{name} {value}"


def _durations(durations: Mapping[tuple[str, str], Durations]) -> list[str]:
    """Write a histogram of request times for each method and route. Routes contain placeholders for parameters."""
    name = "damperlab_request_duration_seconds"
    lines = [f"# HELP {name} Time until an answer was complete, by route.", f"# TYPE {name} histogram"]
    for (method, route), each in sorted(durations.items()):
        labels = f'method="{method}",route="{route}"'
        for bound, count in zip((*map(str, BOUNDS), "+Inf"), each.within, strict=True):
            lines.append(f'{name}_bucket{{{labels},le="{bound}"}} {count}')
        lines += [f"{name}_sum{{{labels}}} {each.seconds}", f"{name}_count{{{labels}}} {each.within[-1]}"]
    return lines
