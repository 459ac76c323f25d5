#!/usr/bin/env bash
# test_install.sh SOURCE CC CXX BUILD: installs the stand-alone libraries, moves the installed tree, and builds and runs a
# stranger's program against it: with find_package, with pkg-config, and with add_subdirectory instead. Then the same with
# each library alone: a copy of its folder under another name, with nothing else of Stilb beside it. Then installs the
# whole of Stilb from BUILD, where it has been built, moves it, and builds and runs examples/ against it.
set -euo pipefail
source=$1 build=$4
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
# ---- the engine ----

refuses() { # WHAT CMAKE-OPTION...: a program that asks for the components engine and gi is told what is missing
	local wanted=$1
	rm -rf "$scratch/consumer"
	if cmake -G Ninja -S "$source/examples" -B "$scratch/consumer" "${@:2}" >"$scratch/log" 2>&1; then
		echo "not noticed: $wanted"
		exit 1
	fi
	tr -s ' \n' ' ' <"$scratch/log" | grep -qF "$wanted" || { cat "$scratch/log"; echo "expected: $wanted"; exit 1; }
}

says() { # TEXT PROGRAM ARGUMENT...: an example prints this and nothing else
	local said
	said=$("$scratch/consumer/$2" "${@:3}" 2>&1) || { echo "$2: exit status $?: $said"; exit 1; }
	[[ $said == $1 ]] || { printf '%s printed:\n%s\nand not:\n%s\n' "$2" "$said" "$1"; exit 1; }
}

missing="this Stilb was built without the engine (STILB_ENGINE=OFF)"
refuses "stilb::engine is missing: $missing. stilb::gi is missing: $missing." -DCMAKE_PREFIX_PATH="$scratch/both"
if [ -e "$build/stilb" ]; then
	quietly cmake --install "$build" --prefix "$scratch/first"
	mv "$scratch/first" "$scratch/whole"
	! grep -rl "$scratch/first" "$scratch/whole" || { echo "these files name the folder they were installed to"; exit 1; }
	has_headers whole base.h base_math.h cull.h engine.h gi_render.h gi_scene.h image.h input.h input_actions.h input_camera.h \
		input_control.h input_pad.h job.h job.hpp job_graph.h job_memory.h job_prof.h job_queue.h job_range.h job_sort.h \
		job_spsc.h prof.h prof_capture.h prof_diff.h prof_inline.h prof_read.h prof_snapshot.h prof_stats.h prof_trace.h \
		render.h scene.h scene_build.h scene_edit.h scene_look.h scene_pick.h scene_variant.h shade_model.h \
		ui_draw.h window.h
	PKG_CONFIG_LIBDIR=$scratch refuses "libpng is not found; on Debian: apt install libpng-dev" \
		-DCMAKE_PREFIX_PATH="$scratch/whole"
	rm -rf "$scratch/consumer"
	quietly cmake -G Ninja -S "$source/examples" -B "$scratch/consumer" -DCMAKE_PREFIX_PATH="$scratch/whole"
	quietly cmake --build "$scratch/consumer"
	engine_flags=$(PKG_CONFIG_PATH=$(dirname "$(find "$scratch/whole" -name stilb-engine.pc)") pkg-config --cflags --libs stilb-engine)
	# shellcheck disable=SC2086 # words of a command line
	quietly "$CXX" -Wall -Werror "$here/engine_consumer/consumer.cpp" -o "$scratch/consumer/middle" $engine_flags
	cd "$scratch"
	printf 'v -1 0 1\nv 1 0 1\nv 1 2 1\nv -1 2 1\nf 1 2 3 4\n' >square.obj
	says "2 of 2 models drawn: own_scene.png" own_scene
	says "1[5-9][0-9] [5-9][0-9] [5-9][0-9]" middle own_scene.png # the ball's red
	says "64 lights, 10 frames: many_lights.png" many_lights
	says "[1-9]* of 1000 models in frame 60: together.json" together
	grep -q '"place models"' together.json && grep -q '"mine 1"' together.json && grep -q '"worker 1"' together.json
	says "cornell by 16 samples a pixel: raytrace.png" raytrace cornell raytrace.png
	says "*1 models, 2 triangles, 1 materials, 0 textures" file square.obj
	# The page for newcomers, as it stands: its first C program, built and run by its commands, in an empty folder.
	mkdir "$scratch/newcomer" && cd "$scratch/newcomer"
	awk '/^```c$/ { inside = 1; next } /^```/ { if (inside) exit } inside' "$source/docs/engine.md" >first.c
	sed -n 's|^cc first.c|'"$CC"' first.c|p; /^export PKG_CONFIG_PATH/p; s/ *# a built-in scene$//p' "$source/docs/engine.md" >run.sh
	[ "$(wc -l <run.sh)" = 3 ] || { cat run.sh; echo "docs/engine.md has other commands"; exit 1; }
	ln -s "$scratch/whole" stilb
	said=$(HOME=$PWD bash -e run.sh) || { echo "the program of docs/engine.md fails: $said"; exit 1; }
	[[ $said == [1-9]*" models in view: first.png" && -s first.png ]] ||
		{ echo "the program of docs/engine.md printed: $said"; exit 1; }
	# The shared library, which takes the components over where it is installed.
	library=$build/lib/libstilb.so
	[[ $(readelf --dynamic "$library") =~ SONAME.*\[libstilb\.so\.[0-9]+\.[0-9]+\] ]] || { echo "$library has no version"; exit 1; }
	"$here/exports.sh" "$library" | diff "$here/exports.txt" - || {
		echo "libstilb.so exports other names than exports.txt lists; exports.sh says how to write it anew"
		exit 1
	}
	quietly cmake --install "$build" --component shared --prefix "$scratch/first"
	cp -r "$scratch/first/." "$scratch/whole" && rm -r "$scratch/first"
	rm -rf "$scratch/consumer"
	quietly cmake -G Ninja -S "$source/examples" -B "$scratch/consumer" -DCMAKE_PREFIX_PATH="$scratch/whole"
	quietly cmake --build "$scratch/consumer"
	readelf --dynamic "$scratch/consumer/raytrace" | grep -q 'NEEDED.*libstilb\.so\.' || { echo "raytrace is not linked to it"; exit 1; }
	cd "$scratch"
	says "2 of 2 models drawn: own_scene.png" own_scene
	says "cornell by 16 samples a pixel: raytrace.png" raytrace cornell raytrace.png
	says "*1 models, 2 triangles, 1 materials, 0 textures" file square.obj
	says "[1-9]* of 1000 models in frame 60: together.json" together
fi
echo "the installed libraries work from CMake, from pkg-config and as a subdirectory"
