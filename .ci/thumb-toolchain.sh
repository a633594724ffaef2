#!/bin/bash
# A toolchain with thumbv7em-none-eabihf where rustup cannot download one: Debian's compiler and its sources.
# usage: thumb-toolchain.sh DIR; then `rustup toolchain link thumb DIR` and RUSTUP_TOOLCHAIN=thumb.
# needs: rustc-web cargo-web rust-web-src rust-web-clippy lld
set -euo pipefail
dir=$(realpath -m "$1")
target=thumbv7em-none-eabihf
host=x86_64-unknown-linux-gnu
version=$(/usr/bin/rustc -V)
stamp="$dir/.version"
if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$version" ]; then exit 0; fi

rm -rf "$dir"
mkdir -p "$dir/bin" "$dir/lib/rustlib/$target/lib" "$dir/lib/rustlib/$host/bin"
debian="$(/usr/bin/rustc --print sysroot)/lib/rustlib"
rust_lld="$HOME/.rustup/toolchains/stable-$host/lib/rustlib/$host/bin/rust-lld"
if [ ! -x "$rust_lld" ]; then rust_lld=$(command -v lld); fi
ln -s "$rust_lld" "$dir/lib/rustlib/$host/bin/rust-lld"
ln -s "$debian/$host/lib" "$dir/lib/rustlib/$host/lib"
ln -s "$debian/src" "$dir/lib/rustlib/src"
printf '#!/bin/sh\nexec /usr/bin/rustc --sysroot "%s" "$@"\n' "$dir" > "$dir/bin/rustc"
chmod +x "$dir/bin/rustc"
for tool in cargo rustdoc cargo-clippy clippy-driver; do
    if [ -x "/usr/bin/$tool" ]; then ln -s "/usr/bin/$tool" "$dir/bin/$tool"; fi
done

# core and alloc for the target; a fixed path keeps the crates' hashes stable
build="$dir/.build"
trap 'rm -rf "$build"' EXIT
mkdir -p "$build/src"
printf '#![no_std]\n' > "$build/src/lib.rs"
cat > "$build/Cargo.toml" <<'TOML'
[package]
name = "stub"
version = "0.0.0"
edition = "2021"
[workspace]
[profile.release]
panic = "abort"
TOML
(
    cd "$build"
    RUSTFLAGS="-Cembed-bitcode=yes" RUSTC_BOOTSTRAP=1 RUSTC=/usr/bin/rustc CARGO_TARGET_DIR="$build/target" \
        /usr/bin/cargo build -q --release -Zbuild-std=core,alloc \
        -Zbuild-std-features=compiler-builtins-mem --target "$target"
)
cp "$build"/target/"$target"/release/deps/lib{core,alloc,compiler_builtins}-*.rlib "$dir/lib/rustlib/$target/lib/"
echo "$version" > "$stamp"
