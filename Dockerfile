# One image for scheduler, workers and service: Dask pickles functions by module path, so all must hold the same code.
FROM python:3.11-slim

ENV PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    PIP_DISABLE_PIP_VERSION_CHECK=1 \
    PIP_NO_CACHE_DIR=1

WORKDIR /app

# What prints reports as PDF; a font comes along.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends libpangoft2-1.0-0 libharfbuzz-subset0 \
    && rm -rf /var/lib/apt/lists/*

# Dependencies first: they change seldom, and the layer is kept while the code changes.
COPY requirements-image.lock ./
RUN python -m pip install --require-hashes -r requirements-image.lock

COPY pyproject.toml README.md LICENSE ./
COPY src src
COPY studies studies
COPY worker worker
COPY service service
# Kernels are compiled into the installed package, so that no container waits for the compiler. Sources first: what follows
# changes seldom then.
RUN python -m pip install --no-deps --no-build-isolation . \
    && rm -rf /app/* \
    && python -m damperlab.worker.shipping \
    && useradd --create-home --uid 1000 damperlab \
    && install --directory --owner damperlab --group damperlab /data \
    && install --directory --owner damperlab --group damperlab --mode 0700 /certificates \
    && install --directory --owner damperlab --group damperlab /database-key /store-key /objects

USER damperlab
WORKDIR /home/damperlab

ENV DAMPERLAB_DATA_DIR=/data
VOLUME /data
EXPOSE 8000

HEALTHCHECK --interval=10s --timeout=5s --start-period=30s \
    CMD ["python", "-c", "import urllib.request as r; r.urlopen('http://127.0.0.1:8000/health/ready', timeout=4)"]

# Refuses to start until there is a key (`damperlab admin keys create`) or DAMPERLAB_ACCESS=open says that none is wanted.
CMD ["damperlab", "serve", "--host", "0.0.0.0"]
