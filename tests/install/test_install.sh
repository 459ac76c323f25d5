#!/usr/bin/env bash
# test_install.sh SOURCE CC CXX: installs the stand-alone libraries, moves the installed tree, and builds and runs a
# stranger's program against it: with find_package, with pkg-config, and with add_subdirectory instead. Then the same with
# each library alone: a copy of its folder under another name, with nothing else of Stilb beside it.
set -euo pipefail
source=$1
export CC=$2 CXX=$3
CMAKE_C_COMPILER_LAUNCHER=$(command -v ccache || true) # the same files are compiled six times
export CMAKE_C_COMPILER_LAUNCHER
[ -n "$CMAKE_C_COMPILER_LAUNCHER" ] || unset CMAKE_C_COMPILER_LAUNCHER
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

runs() { # PROGRAM: must print the sum that it computes with the libraries
	local said
	said=$("$1") || { echo "$1: exit status $?"; exit 1; }
	[ "$said" = "sum 499500" ] || { echo "$1 printed: $said"; exit 1; }
}

install_moved() { # SOURCE NAME OPTION...: builds SOURCE, installs it, and leaves the installed tree in $scratch/NAME
	local folder=$1 name=$2
	quietly cmake -G Ninja -S "$folder" -B "$scratch/build-$name" -DCMAKE_BUILD_TYPE=Release "${@:3}"
	quietly cmake --build "$scratch/build-$name"
	quietly cmake --install "$scratch/build-$name" --prefix "$scratch/first"
	mv "$scratch/first" "$scratch/$name"
	! grep -rl "$scratch/first" "$scratch/$name" || { echo "these files name the folder they were installed to"; exit 1; }
}

builds() { # CONSUMER OPTION...: its programs build and run
	rm -rf "$scratch/consumer"
	quietly cmake -G Ninja -S "$here/$1" -B "$scratch/consumer" "${@:2}"
	quietly cmake --build "$scratch/consumer"
	for program in "$scratch/consumer"/consumer*; do
		runs "$program"
	done
}

builds_by_pkg_config() { # PREFIX COMPILER SOURCE PACKAGE...
	local flags
	read -ra flags < <(PKG_CONFIG_PATH=$(dirname "$(find "$1" -name '*.pc' | head -n 1)") pkg-config --cflags --libs "${@:4}")
	quietly "$2" "$here/$3" -o "$scratch/pkg" "${flags[@]}"
	runs "$scratch/pkg"
}

has_headers() { # NAME HEADER...: the headers installed to $scratch/NAME are these
	local found
	found=$(cd "$scratch/$1/include/stilb" && LC_ALL=C && echo *)
	[ "$found" = "${*:2}" ] || { echo "$1 installs the headers $found instead of ${*:2}"; exit 1; }
}

install_moved "$source" both -DSTILB_ENGINE=OFF -DSTILB_TESTS=OFF
builds consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds jobs_consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds profiler_consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds_by_pkg_config "$scratch/both" "$CC" consumer/consumer.c stilb-jobs stilb-profiler
builds consumer -DSTILB_FOLDER="$source"

mkdir "$scratch/elsewhere"
cp -r "$source/jobs" "$scratch/elsewhere/job-system"
install_moved "$scratch/elsewhere/job-system" alone
has_headers alone job.h job.hpp job_graph.h job_memory.h job_queue.h job_range.h job_sort.h job_spsc.h
builds jobs_consumer -DCMAKE_PREFIX_PATH="$scratch/alone"
builds_by_pkg_config "$scratch/alone" "$CC" jobs_consumer/consumer.c stilb-jobs
builds_by_pkg_config "$scratch/alone" "$CXX" jobs_consumer/consumer.cpp stilb-jobs
builds jobs_consumer -DJOBS_FOLDER="$scratch/elsewhere/job-system"

cp -r "$source/profiler" "$scratch/elsewhere/frame-profiler"
install_moved "$scratch/elsewhere/frame-profiler" profiler-alone
has_headers profiler-alone prof.h prof_capture.h prof_diff.h prof_inline.h prof_read.h prof_snapshot.h prof_stats.h prof_trace.h
builds profiler_consumer -DCMAKE_PREFIX_PATH="$scratch/profiler-alone"
builds_by_pkg_config "$scratch/profiler-alone" "$CC" profiler_consumer/consumer.c stilb-profiler
builds_by_pkg_config "$scratch/profiler-alone" "$CXX" profiler_consumer/consumer.cpp stilb-profiler
builds profiler_consumer -DPROFILER_FOLDER="$scratch/elsewhere/frame-profiler"
echo "the installed libraries work from CMake, from pkg-config and as a subdirectory"
