"""Settings of the service, from environment variables (``DAMPERLAB_…``) and from options of the command line."""

import json
from ipaddress import ip_network
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ByteSize, Field, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from damperlab.service.documentation import FIRST, built
from damperlab.service.scheduler_address import FORM, is_address
from damperlab.studies.store.opening import default_data_dir
from damperlab.studies.vocabulary import BatchSystem, Scope

if TYPE_CHECKING:
    from damperlab.studies.design.shelf import Shelf as Designs
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.store.store import Store


PREFIX = "DAMPERLAB_"
OTHER_VARIABLES = (
    # variables of kernels, workers, and the client
    *("CACHE_DIR", "TARGET", "CLUSTER_TLS", "URL", "KEY", "KEY_FILE"),
    # variables of tests
    *("DURATIONS", "PICTURES"),
)
"""Environment variables of other parts of damperlab, without the prefix."""


class Settings(BaseSettings):
    """Settings of the service.

    Each setting has an environment variable, for example ``DAMPERLAB_DATA_DIR`` for `data_dir`. Arguments of the
    constructor take precedence over the environment.
    """

    model_config = SettingsConfigDict(
        env_prefix=PREFIX,
        extra="forbid",
        frozen=True,
        env_ignore_empty=True,
        # this value removes a limit that has a default
        env_parse_none_str="none",
    )

    data_dir: Path = Field(
        default_factory=default_data_dir, description="Folder of the cubes and the catalogue."
    )
    catalogue: str | None = Field(
        None,
        description="postgresql://… for the catalogue; by default it is a SQLite file in the data folder.",
        repr=False,
    )
    store: str | None = Field(
        None,
        description="s3://bucket/prefix for the cubes; by default the location stored in the catalogue. A "
        "new catalogue stores the data folder. The server and the keys come from AWS_ENDPOINT_URL, "
        "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, …",
    )
    quota_bytes: ByteSize | None = Field(
        None,
        ge=0,
        description="Largest number of bytes that studies may take before compression, as in 50GB.",
    )
    quota_points: int | None = Field(
        None, ge=0, description="Largest number of points that studies may have."
    )
    quota_unfinished: int | None = Field(
        None, ge=1, description="Largest number of studies that wait or run."
    )
    quota_records: int | None = Field(
        1000, ge=0, description="Largest number of uploaded ground-motion records."
    )
    quota_designs: int | None = Field(1000, ge=0, description="Largest number of designs.")
    requests_per_minute: int | None = Field(
        None, ge=1, description="Largest number of requests a minute of all callers together."
    )
    key_quota_bytes: ByteSize | None = Field(
        ByteSize(50 * 10**9), ge=0, description="Largest number of bytes of the studies of one owner of keys."
    )
    key_quota_points: int | None = Field(
        100_000_000, ge=0, description="Largest number of points of the studies of one owner of keys."
    )
    key_quota_unfinished: int | None = Field(
        1000, ge=1, description="Largest number of studies of one owner of keys that wait or run."
    )
    key_quota_records: int | None = Field(
        100, ge=0, description="Largest number of uploaded ground-motion records of one owner of keys."
    )
    key_quota_designs: int | None = Field(
        100, ge=0, description="Largest number of designs of one owner of keys."
    )
    key_requests_per_minute: int | None = Field(
        6000, ge=1, description="Largest number of requests a minute with one key."
    )
    reuse: bool = Field(True, description="Reuse points already computed by earlier studies.")
    host: str = Field("127.0.0.1", description="Address to listen on; loopback by default.")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on; 0 takes a free one and logs it.")
    access: Literal["auto", "keys", "open"] = Field(
        "auto",
        description="Who may send requests. `keys`: callers with a key; `open`: everyone; `auto`: `open` on "
        "loopback and `keys` elsewhere.",
    )
    hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        (),
        description="Further host names of the service, separated by commas; .example.org for every name under it.",
    )
    trusted_proxies: Annotated[tuple[str, ...], NoDecode] = Field(
        (), description="Addresses or networks of reverse proxies that are trusted, separated by commas."
    )
    proxy_user_header: str | None = Field(
        None,
        description="Header in which a trusted proxy names the authenticated user, as in X-Forwarded-User.",
    )
    proxy_scope: Scope = Field("submit", description="Scope of a user whom a trusted proxy names.")
    docs_dir: Path | None = Field(
        default_factory=built,
        description="Folder of the documentation site, to which the page links; by default the output of "
        "`make docs`. none for no links.",
    )
    tls_certificate: Path | None = Field(
        None, description="File of the certificate chain, in PEM; with it the service uses TLS."
    )
    tls_key: Path | None = Field(None, description="File of the certificate's private key, in PEM.")
    workers: int | None = Field(
        None,
        ge=1,
        le=1024,
        description="Worker processes of the embedded cluster; with `cluster`, the largest number of jobs.",
    )
    scheduler: str | None = Field(
        None, description="Address of a Dask scheduler to use in place of an embedded cluster."
    )
    cluster: BatchSystem | None = Field(
        None, description="Batch system whose jobs are the workers; this machine runs the scheduler."
    )
    cluster_host: str | None = Field(
        None, description="Name or address by which jobs reach this machine; its host name by default."
    )
    job_seconds: float = Field(
        3600.0, gt=0.0, description="Wall time of a job, in seconds; the worker leaves before the job ends."
    )
    job_memory_bytes: ByteSize = Field(
        ByteSize(2 << 30), ge=1 << 28, description="Memory of a job, as in 2GiB."
    )
    job_options: str = Field(
        "",
        pattern=r"^[^\r\n]*$",
        description="Further options of the batch system for every job, as in --partition=short "
        "--account=lab.",
    )
    warm: bool = Field(
        True,
        description="At the start, compile missing kernels for the usual studies, points and earthquakes in "
        "the background.",
    )
    studies_at_once: int = Field(
        2, ge=1, le=64, description="Number of studies that run at the same time; they share one cluster."
    )
    designs_at_once: int = Field(
        2,
        ge=1,
        le=64,
        description="Number of designs that are searched at the same time, each in a separate process.",
    )
    catalogue_wait_seconds: float = Field(
        10.0,
        gt=0.0,
        le=60.0,
        description="Longest wait of a request for the catalogue's write lock, in seconds.",
    )
    body_limit_bytes: int = Field(4 * 1024 * 1024, ge=1024, description="Largest request body, in bytes.")
    simulate_cycles_limit: int = Field(
        100_000, ge=1, description="Largest number of excitation cycles of one simulation."
    )
    simulate_history_limit: int = Field(
        20_000, ge=0, description="Largest number of samples of one time history."
    )
    work_seconds: float = Field(
        90.0,
        gt=0.0,
        description="Largest processor time of a point, a comparison or an upload, in seconds.",
    )
    work_wait_seconds: float = Field(
        1800.0,
        gt=0.0,
        description="Largest wall time of the computation for a request, in seconds, including its wait for "
        "a process.",
    )
    work_memory_bytes: ByteSize = Field(
        ByteSize(4 << 30),
        ge=1 << 29,
        description="Largest memory of a process that computes for a request, as in 4GiB.",
    )
    question_points_apart: int = Field(
        50_000,
        ge=0,
        description="Smallest number of points of a study whose queries are answered in a separate process.",
    )
    streams_per_caller: int = Field(
        100,
        ge=1,
        description="Largest number of open streams of events of one key or, without keys, of one address.",
    )
    exports_per_caller: int = Field(
        32,
        ge=1,
        description="Largest number of simultaneous exports of one key or, without keys, of one address.",
    )
    connections_limit: int = Field(1000, ge=1, description="Largest number of simultaneous connections.")
    address_connections_limit: int = Field(
        250,
        ge=1,
        description="Largest number of connections from one address, except trusted proxies; a further "
        "connection closes the connection that has been idle longest.",
    )
    head_timeout_seconds: float = Field(
        60.0,
        gt=0.0,
        description="Longest time for receiving the head of a request, in seconds. A browser on a busy machine "
        "may need more than ten seconds.",
    )
    body_timeout_seconds: float = Field(
        60.0, gt=0.0, description="Longest time for receiving the body of a request, in seconds."
    )
    cors_origins: Annotated[tuple[str, ...], NoDecode] = Field(
        (),
        description="Web origins that may call from a browser, separated by commas; none by default.",
    )
    log_level: Literal["critical", "error", "warning", "info", "debug"] = Field(
        "info", description="Lowest severity that is logged."
    )
    log_format: Literal["text", "json"] = Field(
        "text", description="Form of the log: readable lines, or one JSON object per line."
    )

    @field_validator("data_dir")
    @classmethod
    def _absolute(cls, value: Path) -> Path:
        # workers with another working directory would read a relative path as another folder
        return value.expanduser().absolute()

    @field_validator("hosts", "trusted_proxies", "cors_origins", mode="before")
    @classmethod
    def _separated(cls, value: object) -> object:
        if not isinstance(value, str):
            return value
        if not value.lstrip().startswith("["):
            return tuple(filter(None, map(str.strip, value.split(","))))
        try:
            return json.loads(value)
        except ValueError:
            raise ValueError("Write them separated by commas, or as a list in JSON") from None

    @field_validator("trusted_proxies")
    @classmethod
    def _networks(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for each in value:
            ip_network(each, strict=False)
        return value

    @field_validator("scheduler")
    @classmethod
    def _an_address(cls, value: str | None) -> str | None:
        if value is not None and not is_address(value):
            raise ValueError(f"Write it as in {FORM}")
        return value

    @field_validator("docs_dir")
    @classmethod
    def _a_site(cls, value: Path | None) -> Path | None:
        if value is not None and not (value / FIRST).is_file():
            raise ValueError(
                f"found {value}, which has no {FIRST}; allowed: the folder that `make docs` builds"
            )
        return value

    @model_validator(mode="after")
    def _certificate_and_key(self) -> "Settings":
        if (self.tls_certificate is None) != (self.tls_key is None):
            raise ValueError(
                "found one of tls_certificate and tls_key; allowed: both or none. Name both files"
            )
        return self

    @model_validator(mode="after")
    def _one_cluster(self) -> "Settings":
        if self.cluster is not None and self.scheduler is not None:
            raise ValueError(
                f"found cluster {self.cluster!r} and scheduler {self.scheduler!r}; allowed: one of the two. "
                "A batch system's jobs work for their own scheduler, so leave `scheduler` out"
            )
        if self.workers is not None and self.scheduler is not None:
            raise ValueError(
                f"found {self.workers} workers and scheduler {self.scheduler!r}; allowed: one of the two. "
                "A scheduler has its own workers, so leave `workers` out"
            )
        return self

    @property
    def designs(self) -> "Designs":
        """Store of designs in the data folder."""
        from damperlab.studies.design.shelf import Shelf
        from damperlab.studies.store.kept_quota import KeptQuota

        return Shelf(self.data_dir, KeptQuota(self.quota_designs, self.key_quota_designs))

    @property
    def records(self) -> "Shelf":
        """Store of ground-motion records in the data folder."""
        from damperlab.studies.ground.shelf import Shelf
        from damperlab.studies.store.kept_quota import KeptQuota

        return Shelf(self.data_dir, KeptQuota(self.quota_records, self.key_quota_records))

    def open_store(self, **options: Any) -> "Store":
        """Open the store of studies that the settings describe.

        Parameters
        ----------
        **options
            Further arguments of `Store.open`.

        Raises
        ------
        StoreFault
            If the store cannot be opened.
        """
        from damperlab.studies.store.catalogue.quota import Quota
        from damperlab.studies.store.store import Store

        each = Quota(
            self.key_quota_points, self.key_quota_bytes, self.key_quota_unfinished, setting="key_quota"
        )
        quota = Quota(self.quota_points, self.quota_bytes, self.quota_unfinished, each)
        return Store.open(self.data_dir, self.catalogue, self.store, quota, **options)
