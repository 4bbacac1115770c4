# The three programs on a small system: docker build -t bedload .
# A run needs shared memory: docker run --rm --shm-size=1g -v "$PWD":/work bedload run scene.toml
FROM rust:1.95-bookworm AS build
# The image's own toolchain, whatever rust-toolchain.toml says.
ENV RUSTUP_TOOLCHAIN=1.95.0
WORKDIR /bedload
COPY . .
RUN cargo build --release --locked

FROM debian:bookworm-slim
COPY --from=build /bedload/target/release/bedload /bedload/target/release/bedload-fluid \
    /bedload/target/release/bedload-dem /usr/local/bin/
WORKDIR /work
ENTRYPOINT ["bedload"]
