# The program in a container, with what `make setup` installs on Debian: apt-packages.txt and constraints.txt.
# Not tried yet: no image was built of it. The same lists and the same `make setup` were, on bare Debian 12 and 13.
#
#   docker build -t orchestrator .                                        # Debian 13: --build-arg RELEASE=trixie
#   docker run --rm -v "$PWD:/work" orchestrator limit wall.json
ARG RELEASE=bookworm
FROM debian:${RELEASE}-slim
RUN apt-get update -q && apt-get install -y -q --no-install-recommends ca-certificates make
WORKDIR /project
COPY . .
RUN make setup && rm -rf /var/lib/apt/lists/*
ENV OMP_NUM_THREADS=1
WORKDIR /work
ENTRYPOINT ["/project/.venv/bin/orchestrator"]
