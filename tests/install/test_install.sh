#!/usr/bin/env bash
# test_install.sh SOURCE CC CXX BUILD: installs the stand-alone libraries, moves the installed tree, and builds and runs a
# stranger's program against it: with find_package, with pkg-config, and with add_subdirectory instead. Then the same with
# each library alone: a copy of its folder under another name, with nothing else of Stilb beside it. Then installs the
# whole of Stilb from BUILD, where it has been built, moves it to a folder with a blank in its name, and builds and runs
# examples/ against it, linked statically and then with the shared library.
#
# What is tested is what is found and linked, not how fast it is: everything is compiled without optimisation, and the
# libraries, which are built five times besides BUILD, as one file each.
set -euo pipefail
source=$1 build=$4
export CC=$2 CXX=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
display=
trap '[ -z "$display" ] || kill "$display"; rm -rf "$scratch"' EXIT
unset CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER # no cache: every path is new
unset LD_LIBRARY_PATH PKG_CONFIG_PATH # the ones of the installed trees alone

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

# empty FOLDER: an empty build folder in which CMake need not look at the compilers again: the first has done that.
empty() {
	rm -rf "$1"
	mkdir -p "$1/CMakeFiles"
	[ ! -d "$scratch/compilers" ] || cp -r "$scratch/compilers/." "$1/CMakeFiles"
}

configures() { # FOLDER BUILD OPTION...
	empty "$2"
	quietly cmake -G Ninja -S "$1" -B "$2" "${@:3}"
	if [ ! -d "$scratch/compilers" ] && [ -e "$(echo "$2"/CMakeFiles/3.*/CMakeCXXCompiler.cmake)" ]; then
		mkdir "$scratch/compilers"
		cp -r "$2"/CMakeFiles/3.* "$scratch/compilers"
	fi
}

not_named() { # FOLDER TREE: no file of the tree names the folder
	! grep -rlF "$1" "$2" || { echo "these files name the folder they were installed to"; exit 1; }
}

# install_moved SOURCE NAME OPTION...: builds SOURCE, installs it, and leaves the installed tree in $scratch/NAME. Of the
# examples, which the tests of each library build and run, it builds none.
install_moved() {
	local folder=$1 name=$2
	configures "$folder" "$scratch/build-$name" -DCMAKE_BUILD_TYPE=None "${@:3}"
	mapfile -t libraries < <(cmake --build "$scratch/build-$name" --target help | sed -n 's/^\(stilb-[a-z]*\): phony$/\1/p')
	quietly cmake --build "$scratch/build-$name" --target "${libraries[@]}"
	quietly cmake --install "$scratch/build-$name" --prefix "$scratch/first"
	mv "$scratch/first" "$scratch/$name"
	not_named "$scratch/first" "$scratch/$name"
}

builds() { # CONSUMER OPTION...: its programs build and run
	configures "$here/$1" "$scratch/consumer" "${@:2}"
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

unity=(-DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0) # names are unique in a module: statics.sh
install_moved "$source" both -DSTILB_ENGINE=OFF -DSTILB_TESTS=OFF "${unity[@]}"
builds consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds jobs_consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds profiler_consumer -DCMAKE_PREFIX_PATH="$scratch/both"
builds_by_pkg_config "$scratch/both" "$CC" consumer/consumer.c stilb-jobs stilb-profiler
builds consumer -DSTILB_FOLDER="$source" "${unity[@]}"

mkdir "$scratch/elsewhere"
cp -r "$source/jobs" "$scratch/elsewhere/job-system"
install_moved "$scratch/elsewhere/job-system" alone "${unity[@]}"
has_headers alone job.h job.hpp job_graph.h job_memory.h job_queue.h job_range.h job_sort.h job_spsc.h
builds jobs_consumer -DCMAKE_PREFIX_PATH="$scratch/alone"
builds_by_pkg_config "$scratch/alone" "$CC" jobs_consumer/consumer.c stilb-jobs
builds_by_pkg_config "$scratch/alone" "$CXX" jobs_consumer/consumer.cpp stilb-jobs
builds jobs_consumer -DJOBS_FOLDER="$scratch/elsewhere/job-system" "${unity[@]}"

cp -r "$source/profiler" "$scratch/elsewhere/frame-profiler"
install_moved "$scratch/elsewhere/frame-profiler" profiler-alone "${unity[@]}"
has_headers profiler-alone prof.h prof_capture.h prof_diff.h prof_inline.h prof_read.h prof_snapshot.h prof_stats.h prof_trace.h
builds profiler_consumer -DCMAKE_PREFIX_PATH="$scratch/profiler-alone"
builds_by_pkg_config "$scratch/profiler-alone" "$CC" profiler_consumer/consumer.c stilb-profiler
builds_by_pkg_config "$scratch/profiler-alone" "$CXX" profiler_consumer/consumer.cpp stilb-profiler
builds profiler_consumer -DPROFILER_FOLDER="$scratch/elsewhere/frame-profiler" "${unity[@]}"

# ---- the engine ----

refuses() { # WHAT ASKED CMAKE-OPTION...: a program that asks for these components is told what is missing
	empty "$scratch/consumer"
	if cmake -G Ninja -S "$here/ask" -B "$scratch/consumer" -DASKED="$2" "${@:3}" >"$scratch/log" 2>&1; then
		echo "not noticed: $1"
		exit 1
	fi
	tr -s ' \n' ' ' <"$scratch/log" | grep -qF "$1" || { cat "$scratch/log"; echo "expected: $1"; exit 1; }
}

finds() { # PREFIX PATH: of the installations in the path, the program gets the one in PREFIX
	empty "$scratch/consumer"
	quietly cmake -G Ninja -S "$here/ask" -B "$scratch/consumer" -DVERSION=0.2 -DASKED="jobs;profiler" -DCMAKE_PREFIX_PATH="$2"
	grep -qF "found 0.2.0 in $1/" "$scratch/log" || { cat "$scratch/log"; echo "expected the Stilb in $1"; exit 1; }
}

says() { # TEXT PROGRAM ARGUMENT...: an example prints this and nothing else
	local said
	said=$("$scratch/consumer/$2" "${@:3}" 2>&1) || { echo "$2: exit status $?: $said"; exit 1; }
	[[ $said == $1 ]] || { printf '%s printed:\n%s\nand not:\n%s\n' "$2" "$said" "$1"; exit 1; }
}

# flags PACKAGE...: what pkg-config says, as an array; the prefix has a blank in it
flags() {
	eval "flags=($(PKG_CONFIG_PATH=$packages pkg-config --cflags --libs "$@"))"
}

# Each header alone is C11 without extensions, and all together are C++17, in the words of a compiler that warns.
headers_stand_alone() {
	local header
	flags stilb-engine stilb-gi
	rm -f "$scratch/alone.cpp"
	for header in "$whole"/include/stilb/*.h; do
		[ "${header##*/}" != prof_inline.h ] || continue # a part of prof.h
		echo "#include <stilb/${header##*/}>" >"$scratch/alone.c"
		cat "$scratch/alone.c" >>"$scratch/alone.cpp"
		quietly "$CC" -std=c11 -pedantic -Wall -Wextra -Werror -fsyntax-only "$scratch/alone.c" "${flags[@]}"
	done
	quietly "$CXX" -std=c++17 -Wall -Wextra -Werror -fsyntax-only "$scratch/alone.cpp" "${flags[@]}"
}

builds_examples() {
	configures "$source/examples" "$scratch/consumer" -DCMAKE_PREFIX_PATH="$whole"
	quietly cmake --build "$scratch/consumer"
	cd "$scratch"
}

open_display() {
	Xvfb -displayfd 7 -screen 0 800x600x24 -nolisten tcp 7>"$scratch/display" >"$scratch/log" 2>&1 &
	display=$!
	for _ in {1..100}; do
		[ ! -s "$scratch/display" ] || return 0
		sleep .1
	done
	cat "$scratch/log"
	echo "Xvfb does not start"
	exit 1
}

# The page for newcomers, as it stands: its first C program, built and run by its commands, in an empty folder.
follows_the_page() {
	local said
	mkdir "$scratch/newcomer" && cd "$scratch/newcomer"
	awk '/^```c$/ { inside = 1; next } /^```/ { if (inside) exit } inside' "$source/docs/engine.md" >first.c
	sed -n 's|^cc first.c|'"$CC"' first.c|p; /^export PKG_CONFIG_PATH/p; s/ *# a built-in scene$//p' "$source/docs/engine.md" >run.sh
	[ "$(wc -l <run.sh)" = 3 ] || { cat run.sh; echo "docs/engine.md has other commands"; exit 1; }
	ln -s "$whole" stilb
	said=$(HOME=$PWD bash -e run.sh) || { echo "the program of docs/engine.md fails: $said"; exit 1; }
	[[ $said == [1-9]*" models in view: first.png" && -s first.png ]] ||
		{ echo "the program of docs/engine.md printed: $said"; exit 1; }
}

missing="this Stilb was built without the engine (STILB_ENGINE=OFF)"
refuses "stilb::engine is missing: $missing. stilb::gi is missing: $missing." "engine;gi" -DCMAKE_PREFIX_PATH="$scratch/both"
refuses "stilb::sound is missing: there is no such component: jobs, profiler, scene, geometry, engine, gi." sound \
	-DCMAKE_PREFIX_PATH="$scratch/both"
# Two versions side by side: each program finds its own, in whatever order they stand.
cp -r "$scratch/both" "$scratch/later"
sed -i 's/PACKAGE_VERSION "0\.2\.0"/PACKAGE_VERSION "0.3.0"/; s/0\.2\.0/0.3.0/g' "$scratch/later/lib/cmake/stilb/stilb-config-version.cmake"
finds "$scratch/both" "$scratch/later;$scratch/both"
finds "$scratch/both" "$scratch/both;$scratch/later"
refuses "0.3.0" "jobs" -DVERSION=0.2 -DCMAKE_PREFIX_PATH="$scratch/later"
if [ -e "$build/stilb" ]; then
	# For a prefix that it does not lie in yet, as those who make packages do; then moved.
	DESTDIR=$scratch/stage quietly cmake --install "$build" --prefix /opt/stilb-of-a-test
	whole="$scratch/a place"
	mv "$scratch/stage/opt/stilb-of-a-test" "$whole"
	[ -z "$(find "$scratch/stage" ! -type d)" ] || { find "$scratch/stage"; echo "installed beside the prefix"; exit 1; }
	not_named /opt/stilb-of-a-test "$whole"
	packages=$(dirname "$(find "$whole" -name stilb-engine.pc)")
	has_headers "a place" base.h base_math.h cull.h debug_draw.h engine.h geometry.h geometry_detail.h geometry_horde.h geometry_impostor.h geometry_levels.h geometry_lights.h gi_render.h gi_scene.h gpu.h gpu_device.h gpu_format.h gpu_plan.h image.h input.h input_actions.h input_camera.h \
		input_control.h input_pad.h job.h job.hpp job_graph.h job_memory.h job_prof.h job_queue.h job_range.h job_sort.h \
		job_spsc.h light.h post.h post_preset.h post_table.h prof.h prof_capture.h prof_diff.h prof_inline.h prof_read.h prof_snapshot.h prof_stats.h prof_trace.h \
		render.h scene.h scene_animation.h scene_build.h scene_channel.h scene_edit.h scene_function.h scene_impostor.h scene_lights.h scene_look.h scene_node.h scene_pick.h scene_play.h scene_streams.h scene_surface.h scene_variant.h shade_model.h shadow.h \
		ui_draw.h window.h
	PKG_CONFIG_LIBDIR=$scratch refuses "libpng is not found; on Debian: apt install libpng-dev" scene \
		-DCMAKE_PREFIX_PATH="$whole"
	refuses "stilb::engine is missing: glfw3 3.3 is not found; on Debian: apt install libglfw3-dev. stilb::gi is missing: embree 3 is not found; on Debian: apt install libembree-dev." \
		"engine;gi" -DCMAKE_PREFIX_PATH="$whole" -DCMAKE_DISABLE_FIND_PACKAGE_glfw3=ON -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON
	headers_stand_alone
	builds_examples
	flags --static stilb-engine
	quietly "$CXX" -Wall -Werror "$here/engine_consumer/consumer.cpp" -o "$scratch/consumer/middle" "${flags[@]}"
	printf 'v -1 0 1\nv 1 0 1\nv 1 2 1\nv -1 2 1\nf 1 2 3 4\n' >square.obj
	says "2 of 2 models drawn: own_scene.png" own_scene
	says "1[5-9][0-9] [5-9][0-9] [5-9][0-9]" middle own_scene.png # the ball's red
	says "64 lights, 10 frames: many_lights.png" many_lights
	says "[1-9]* of 300 models drawn as a photograph: own_pass.png" own_pass
	says "48 frames of a ball that dissolves: own_surface.png" own_surface
	says "[1-9][0-9][0-9][0-9] lines and parts of letters drawn: own_debug.png" own_debug
	says "frame 0: 0.[0-9]*W sr^-1 m^-2 in the mean" own_compute
	says "[1-9]* of 1000 models in frame 60: together.json" together
	grep -q '"place models"' together.json && grep -q '"mine 1"' together.json && grep -q '"worker 1"' together.json
	says "cornell by 16 samples a pixel: raytrace.png" raytrace cornell raytrace.png
	says "*1 models, 2 triangles, 1 materials, 0 textures" file square.obj
	follows_the_page
	# The shared library, which takes the components over where it is installed.
	library=$build/lib/libstilb.so
	[[ $(readelf --dynamic "$library") =~ SONAME.*\[libstilb\.so\.[0-9]+\.[0-9]+\] ]] || { echo "$library has no version"; exit 1; }
	"$here/exports.sh" "$library" | diff "$here/exports.txt" - || {
		echo "libstilb.so exports other names than exports.txt lists; exports.sh says how to write it anew"
		exit 1
	}
	quietly cmake --install "$build" --component shared --prefix "$whole"
	refuses "stilb::profiler is missing: find_package(stilb-profiler) gave its static library before" "jobs;profiler" \
		-DCMAKE_PREFIX_PATH="$whole" -DSTATIC_FIRST=ON
	rm "$scratch/own_scene.png" "$scratch/together.json"
	builds_examples
	for program in own_scene file many_lights raytrace together window own_debug own_pass own_compute own_surface; do
		readelf --dynamic "$scratch/consumer/$program" | grep -q 'NEEDED.*libstilb\.so\.' || { echo "$program is not linked to it"; exit 1; }
	done
	says "2 of 2 models drawn: own_scene.png" own_scene
	says "cornell by 16 samples a pixel: raytrace.png" raytrace cornell raytrace.png
	says "*1 models, 2 triangles, 1 materials, 0 textures" file square.obj
	says "[1-9]* of 1000 models in frame 60: together.json" together
	grep -q '"place models"' together.json && grep -q '"mine 1"' together.json && grep -q '"worker 1"' together.json &&
		grep -q '"scene update"' together.json
	# Zones of the program, in C and C++, and of a module that comes and goes, in one timeline with the engine's.
	flags stilb-engine
	quietly "$CC" -Wall -Wextra -Werror -fPIC -shared -fvisibility=hidden "$here/shared_consumer/plugin.c" -o consumer/plugin.so "${flags[@]}"
	quietly "$CXX" -Wall -Wextra -Werror -c "$here/shared_consumer/zones.cpp" -o consumer/zones.o "${flags[@]}"
	quietly "$CC" -Wall -Wextra -Werror "$here/shared_consumer/consumer.c" consumer/zones.o -o consumer/shared \
		-Wl,-rpath,"$(dirname "$packages")" "${flags[@]}"
	says "one timeline" shared consumer/plugin.so
	if command -v Xvfb >/dev/null; then
		open_display
		DISPLAY=:$(cat "$scratch/display") says "12 frames, the last of 320 x 200" window 12
	else
		echo "no Xvfb: the example with a window is built, but not run"
	fi
fi
echo "the installed libraries work from CMake, from pkg-config and as a subdirectory"
