#!/usr/bin/env bash
# test_install.sh SOURCE CC CXX: installs the stand-alone libraries, moves the installed tree, and builds and runs a
# stranger's program against it: with find_package, with pkg-config, and with add_subdirectory instead.
set -euo pipefail
source=$1
export CC=$2 CXX=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

quietly() { # shows what a command said only when it fails
	"$@" >"$scratch/log" 2>&1 || {
		cat "$scratch/log"
		echo "failed: $*"
		exit 1
	}
}

runs() { # PROGRAM: must print the sum that only the two libraries together can
	local said
	said=$("$1") || { echo "$1: exit status $?"; exit 1; }
	[ "$said" = "sum 499500" ] || { echo "$1 printed: $said"; exit 1; }
}

quietly cmake -G Ninja -S "$source" -B "$scratch/build" -DCMAKE_BUILD_TYPE=Release -DSTILB_ENGINE=OFF -DSTILB_TESTS=OFF
quietly cmake --build "$scratch/build"
quietly cmake --install "$scratch/build" --prefix "$scratch/first"
mv "$scratch/first" "$scratch/moved"
! grep -rl "$scratch/first" "$scratch/moved" || { echo "these files name the folder they were installed to"; exit 1; }
[ -f "$scratch/moved/include/stilb/job.h" ] && [ -f "$scratch/moved/include/stilb/prof.h" ]

quietly cmake -G Ninja -S "$here/consumer" -B "$scratch/package" -DCMAKE_PREFIX_PATH="$scratch/moved"
quietly cmake --build "$scratch/package"
runs "$scratch/package/consumer"

PKG_CONFIG_PATH=$(dirname "$(find "$scratch/moved" -name stilb-jobs.pc)")
export PKG_CONFIG_PATH
read -ra flags < <(pkg-config --cflags --libs stilb-jobs stilb-profiler)
quietly "$CC" "$here/consumer/consumer.c" -o "$scratch/pkg" "${flags[@]}"
runs "$scratch/pkg"

quietly cmake -G Ninja -S "$here/consumer" -B "$scratch/folder" -DSTILB_FOLDER="$source"
quietly cmake --build "$scratch/folder"
runs "$scratch/folder/consumer"
echo "the installed libraries work from CMake, from pkg-config and as a subdirectory"
