#!/usr/bin/env bash
# Tests the checks of tests/tree: each must report a violation that is planted in a small tree, and nothing without one.
set -euo pipefail
checks=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
failures=0

# A tree that breaks no rule.
fresh_tree() {
	rm -rf "$scratch/tree"
	mkdir -p "$scratch/tree"/{.ci,jobs,profiler,engine/{base,shading,scene,image,window,gpu/vulkan,render},game,bench,tests}
	cd "$scratch/tree"
	header jobs/job.h STILB_JOB_H '<stdint.h>'
	header jobs/job_queue.h STILB_JOB_QUEUE_H '"job.h"'
	header jobs/job_lock.h STILB_JOB_LOCK_H '"jobs/job.h"'
	header profiler/prof.h STILB_PROF_H '<time.h>'
	header engine/base/base.h STILB_BASE_H '<stddef.h>'
	header engine/scene/scene.h STILB_SCENE_H '"base/base.h"'
	header engine/scene/scene_internal.h STILB_SCENE_INTERNAL_H '"scene/scene.h"' '"profiler/prof.h"'
	header engine/render/render.h STILB_RENDER_H '"scene/scene.h"' '"jobs/job.h"' '"jobs/job_queue.h"'
	header engine/render/render_internal.h STILB_RENDER_INTERNAL_H '"render/render.h"'
	header engine/engine.h STILB_ENGINE_H '"render/render.h"'
	printf '#include "base/base.h"\n#include "triangle_spv.h"\n#include <vulkan/vulkan.h>\n' >engine/gpu/vulkan/vulkan.c
	printf '#include <vector>\n#include <OpenImageIO/imageio.h>\n' >engine/image/oiio.cpp
	printf '#include "engine.h"\n#include <sys/stat.h>\n' >game/main.c
	header engine/shading/shade_sky.h SHADE_SKY_H '"base/base.h"'
	printf '#include "../shading/shade_sky.h"\n' >engine/render/sky.frag
	printf '#include "scene/scene_internal.h"\n#include <cmocka.h>\n' >tests/test_scene_build.c
	printf 'stilb_test(test_scene_build LABELS unit)\n' >tests/CMakeLists.txt
	printf 'STILB_REQUIRE=unit\n' >.ci/run
}

header() { # FILE GUARD INCLUDE...
	printf '/* A header. */\n#ifndef %s\n#define %s\n' "$2" "$2" >"$1"
	printf '#include %s\n' "${@:3}" >>"$1"
	echo '#endif' >>"$1"
}

expect() { # WHAT-THE-CHECK-SAYS CHECK FOLDER: the check must fail and say so
	local wanted=$1 said
	shift
	if said=$("$checks/$1" "${@:2}" 2>&1); then
		echo "not noticed: $wanted"
		failures=$((failures + 1))
	elif [[ $said != *"$wanted"* ]]; then
		printf 'expected: %s\nbut %s said:\n%s\n' "$wanted" "$1" "$said"
		failures=$((failures + 1))
	fi
}

expect_good() { # CHECK FOLDER: the check must pass
	local said
	said=$("$checks/$1" "${@:2}" 2>&1) || {
		printf 'a tree without fault fails in %s:\n%s\n' "$1" "$said"
		failures=$((failures + 1))
	}
}

include() { # FILE INCLUDE WHAT-THE-CHECK-SAYS: layers.sh must report this #include, planted in FILE
	fresh_tree
	printf '#include %s\n' "$2" >>"$1"
	expect "$3" layers.sh "$scratch/tree"
}

test_layers() {
	fresh_tree
	expect_good layers.sh "$scratch/tree"
	include jobs/job.h '"base/base.h"' 'jobs may not include base'
	include jobs/job.h '"profiler/prof.h"' 'jobs may not include profiler'
	include profiler/prof.h '"jobs/job.h"' 'profiler may not include jobs'
	include engine/base/base.h '"profiler/prof.h"' 'base may not include profiler'
	include engine/scene/scene.h '"render/render.h"' 'engine/scene/scene.h:6: scene may not include render'
	include engine/base/base.h '"jobs/job.h"' 'base may not include jobs'
	include engine/render/render.h '"scene/scene_internal.h"' '"scene/scene_internal.h" is internal to scene'
	include engine/render/render.h '"jobs/job_lock.h"' '"jobs/job_lock.h" is internal to jobs'
	include engine/render/render.h '"engine.h"' 'render may not include engine'
	include game/main.c '"render/render.h"' 'game may not include render'
	include bench/record.c '"render/render_internal.h"' '"render/render_internal.h" is internal to render'
	fresh_tree
	printf '#include "scene/scene_internal.h"\n' >bench/gi.c
	expect_good layers.sh "$scratch/tree"
	include engine/scene/scene.h '"../base/base.h"' 'name headers from the top'
	include engine/render/sky.frag '"../engine.h"' 'render may not include engine'
	include engine/scene/scene.h '"base/gone.h"' 'is not in the tree'
	include engine/scene/scene.h '<vulkan/vulkan.h>' '<vulkan/vulkan.h> belongs to engine/gpu/vulkan alone'
	include engine/render/render.h '<vulkan/vulkan.h>' '<vulkan/vulkan.h> belongs to'
	include game/main.c '<GLFW/glfw3.h>' '<GLFW/glfw3.h> belongs to'
	include game/main.c '<cmocka.h>' '<cmocka.h> belongs to'
	include game/main.c '<zlib.h>' '<zlib.h> is neither'
	include game/main.c '<vector>' '<vector> is neither'
	include game/main.c 'SOME_MACRO' 'must name its header'
	fresh_tree
	mkdir -p build out && touch out/CMakeCache.txt
	printf '#include "nowhere/gone.h"\n' | tee build/a.c >out/a.c
	expect_good layers.sh "$scratch/tree"
	mkdir extra && printf '#include <stdio.h>\n' >extra/a.c
	expect 'to no module' layers.sh "$scratch/tree"
	rm -rf "$scratch/tree" && mkdir "$scratch/tree"
	expect 'no include at all' layers.sh "$scratch/tree"
}

test_shape() {
	fresh_tree
	expect_good shape.sh "$scratch/tree"
	seq 1501 | sed 's|.*|// &|' >game/long.c
	expect 'game/long.c: 1501 lines' shape.sh "$scratch/tree"

	fresh_tree
	echo 'int stilb_job_x;' >jobs/open.h
	expect 'jobs/open.h: does not start with a header guard' shape.sh "$scratch/tree"
	printf '#include <stdio.h>\n#ifndef A\n#define A\n#endif\n' >jobs/open.h
	expect 'jobs/open.h: does not start with a header guard' shape.sh "$scratch/tree"
	header jobs/open.h STILB_PROF_H '<stdio.h>'
	expect 'the header guard STILB_PROF_H is also that of' shape.sh "$scratch/tree"

	fresh_tree
	echo 'void f(void) { atomic_thread_fence(memory_order_seq_cst); }' >>game/main.c
	expect 'game/main.c:3: a fence' shape.sh "$scratch/tree"

	dialect 'if (p == NULL)' 'a pointer is tested by itself'
	dialect 'return p != NULL;' 'a pointer is tested by itself'
	dialect '++i;' 'a statement increments behind the name'
	dialect 'for (int i = 0; i < 9; ++i)' 'a statement increments behind the name'
	dialect 'const unsigned long n = 9;' 'a local goes without const'
	dialect 'long n = 9l;' 'a suffix L is large'
	dialect 'long n = -0x1fll;' 'a suffix L is large'
	fresh_tree
	printf '\tf(++i, "p == NULL"); /* p == NULL */\n\tconst char *name = "";\n\tstatic const int size = 9;\n' >>game/main.c
	printf '\tconst flag flags[] = {{0}};\n/* If\n * p == NULL\n */\n' >>game/main.c
	expect_good shape.sh "$scratch/tree"

	fresh_tree
	printf '\t\t/* %0110d */\n' 0 >>game/main.c
	expect 'game/main.c:3: 124 columns' shape.sh "$scratch/tree"

	fresh_tree
	mkdir game/pads
	for i in {1..33}; do echo >"game/pads/pads_$i.c"; done
	expect 'game/pads/: 33 files in one folder' shape.sh "$scratch/tree"

	fresh_tree
	echo >tests/test_scene.c
	expect 'tests/test_scene.c: tests/CMakeLists.txt does not name it' shape.sh "$scratch/tree"
	fresh_tree
	mkdir tests/scene
	echo >tests/scene/test_scene_open.c
	echo 'stilb_test(test_scene_opened)' >tests/scene/CMakeLists.txt
	expect 'tests/scene/test_scene_open.c: tests/scene/CMakeLists.txt does not name it' shape.sh "$scratch/tree"

	fresh_tree
	printf 'stilb_test(test_scene_build\n\tLABELS model tsan)\n' >tests/CMakeLists.txt
	expect 'STILB_REQUIRE does not name the tier model' shape.sh "$scratch/tree"
}

dialect() { # STATEMENT WHAT-THE-CHECK-SAYS: shape.sh must report this statement, planted in game/main.c
	fresh_tree
	printf '\t%s\n' "$1" >>game/main.c
	expect "game/main.c:3: $2" shape.sh "$scratch/tree"
}

library() { # MODULE CODE: compiles CODE to a library of that module, which symbols.sh can check
	rm -rf "${scratch:?}/lib" && mkdir -p "$scratch/lib/sub"
	printf '%s\n' "$2" >"$scratch/lib/a.c"
	"${CC:-cc}" -c "$scratch/lib/a.c" -o "$scratch/lib/a.o"
	ar rcs "$scratch/lib/sub/libstilb-$1.a" "$scratch/lib/a.o"
}

test_statics() {
	fresh_tree
	printf 'static int job_helper(void)\n{\n}\nstatic int ready;\n' >jobs/job_pool.c
	printf 'static int cull_helper(void)\n{\n}\n' >engine/scene/scene.c
	expect 'engine/scene/scene.c:1: cull_helper carries the prefix of culling' statics.sh "$scratch/tree"
	printf 'static int scene_helper(void)\n{\n}\nstatic int ready;\n' >engine/scene/scene.c
	expect_good statics.sh "$scratch/tree"
	printf 'static int job_helper(void);\n' >jobs/job_wait.c
	expect_good statics.sh "$scratch/tree"
	printf 'static bool ready[2] = {0};\n' >jobs/job_wait.c
	expect 'jobs/job_wait.c:1: ready is static in jobs/job_pool.c too' statics.sh "$scratch/tree"
}

test_circles() {
	local lib=$scratch/lib
	rm -rf "$lib" && mkdir -p "$lib/sub"
	cd "$lib"
	echo 'int b(void); int a(void) { return b(); }' >a.c
	echo 'int c(void); int b(void) { return c(); }' >b.c
	echo 'int a(void); int c(void) { return 1; }' >c.c
	echo >none.txt
	echo 'x a.c b.c c.c # why' >listed.txt
	archive() {
		rm -f sub/libstilb-x.a
		for f in a b c; do "${CC:-cc}" -O0 -c $f.c -o $f.c.o; done
		ar rcs sub/libstilb-x.a a.c.o b.c.o c.c.o
	}
	archive
	expect_good circles.sh "$lib" none.txt
	expect 'x: circles.txt lists a circle that is not there: a.c b.c c.c' circles.sh "$lib" listed.txt
	echo 'int a(void); int c(void) { return a(); }' >c.c
	archive
	expect 'x: a circle of object files: a.c b.c c.c' circles.sh "$lib" none.txt
	expect_good circles.sh "$lib" listed.txt
}

test_links() {
	local tree=$scratch/links
	rm -rf "$tree" && mkdir -p "$tree/docs"
	printf '# A title\n[good](docs/b.md) [too](docs/b.md#two-words-2) [far](https://example.org)\n```\n[code](gone.md)\n```\n' >"$tree/a.md"
	printf '# Two words: 2\n[back](../a.md#a-title)\n' >"$tree/docs/b.md"
	expect_good links.sh "$tree"
	echo '[lost](gone.md)' >>"$tree/docs/b.md"
	expect 'docs/b.md:3: there is no gone.md' links.sh "$tree"
	printf '# Two words: 2\n[back](../a.md#title)\n' >"$tree/docs/b.md"
	expect 'docs/b.md:2: docs/../a.md has no heading #title' links.sh "$tree"
}

test_symbols() {
	library jobs 'int stilb_job_a; int job_b; static int help = 1; int *stilb_job_c(void) { return &help; }'
	expect_good symbols.sh "$scratch/lib"
	library jobs 'int stilb_prof_a;'
	expect 'libstilb-jobs.a: stilb_prof_a lacks the prefix' symbols.sh "$scratch/lib"
	library culling 'void helper(void) {}'
	expect 'libstilb-culling.a: helper lacks the prefix cull_' symbols.sh "$scratch/lib"
	library render 'void render_a(void) {}'
	expect_good symbols.sh "$scratch/lib"
	library scene 'void render_wait(void) {}'
	expect 'libstilb-scene.a: render_wait lacks the prefix scene_' symbols.sh "$scratch/lib"
	library base 'void stilb_log(void) {}'
	expect_good symbols.sh "$scratch/lib"
	library base 'void write_log(void) {}'
	expect 'libstilb-base.a: write_log' symbols.sh "$scratch/lib"
	echo 'build sub/libstilb-base.a: phony' >"$scratch/lib/build.ninja"
	expect 'libstilb-base.a: write_log' symbols.sh "$scratch/lib"
	echo 'build sub/libstilb-core.a: phony' >"$scratch/lib/build.ninja"
	expect_good symbols.sh "$scratch/lib"
	library window 'char *setlocale(int, const char *); void stilb_window_a(void) { setlocale(0, ""); }'
	expect_good symbols.sh "$scratch/lib"
	library scene 'char *setlocale(int, const char *); void stilb_scene_a(void) { setlocale(0, ""); }'
	expect 'libstilb-scene.a: calls setlocale' symbols.sh "$scratch/lib"
	library scene 'int atexit(void (*)(void)); void stilb_scene_a(void) { atexit(stilb_scene_a); }'
	expect 'libstilb-scene.a: calls atexit' symbols.sh "$scratch/lib"
	rm -rf "${scratch:?}/lib" && mkdir "$scratch/lib"
	expect 'no libstilb-*.a' symbols.sh "$scratch/lib"
}

test_layers
test_shape
test_symbols
test_statics
test_circles
test_links
[ $failures -eq 0 ] || { echo "$failures planted violations went wrong"; exit 1; }
echo "every planted violation was reported"
