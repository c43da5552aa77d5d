# docker build -t grind_env . && docker run grind_env            # make test
# docker run grind_env make benchmark
FROM python:3.12-slim
# git tells results their commit; with gcc the kernel is compared with its source in C
RUN apt-get update && apt-get install --yes --no-install-recommends gcc git libc6-dev make \
    && rm -rf /var/lib/apt/lists/*
ENV NUMBA_CACHE_DIR=/var/cache/grind_env
WORKDIR /grind_env
COPY . .
RUN make setup
CMD ["make", "test"]
