/* The barriers of plans, against lists that were written by hand. gpu_script.h has the language of both. */
#include "gpu_script.h"

#include "support/test.h"

#include <stdlib.h>
#include <string.h>

typedef struct example {
	const char *what;
	const char *rows;
	const char *first; /* barriers of the first frame */
	const char *next;  /* of the second, and of all after it; NULL: as the first */
} example;

static const example examples[] = {
	{"a scene, and a tone map into the picture",
     "image color rgba16_f\n"
     "image depth d32_f\n"
     "image picture rgba8_srgb output\n"
     "draws scene clear:color clear:depth\n"
     "screen tone fresh:picture sample:color\n",
     "scene: color none > color discard\n"
     "scene: depth none > depth discard\n"
     "tone: picture none > color discard\n"
     "tone: color color > sampled_fragment\n"
     "end: picture color > output\n",
     "scene: color sampled_fragment > color discard memory\n"
     "scene: depth depth > depth discard memory\n"
     "tone: picture output > color discard\n"
     "tone: color color > sampled_fragment\n"
     "end: picture color > output\n"},

	{"two readers after one write: one barrier for both",
     "image a rgba8_u output\n"
     "image b rgba8_u output\n"
     "image c rgba8_u output\n"
     "draws write clear:a\n"
     "screen one fresh:b sample:a\n"
     "screen two fresh:c sample:a\n",
     "write: a none > color discard\n"
     "one: b none > color discard\n"
     "one: a color > sampled_fragment\n"
     "two: c none > color discard\n"
     "end: a sampled_fragment > output\n"
     "end: b color > output\n"
     "end: c color > output\n",
     "write: a output > color discard\n"
     "one: b output > color discard\n"
     "one: a color > sampled_fragment\n"
     "two: c output > color discard\n"
     "end: a sampled_fragment > output\n"
     "end: b color > output\n"
     "end: c color > output\n"},

	{"readers in two stages: the barrier before the first names both",
     "image a rgba8_u\n"
     "image b rgba8_u output\n"
     "image c rgba8_u output\n"
     "draws write clear:a\n"
     "screen one fresh:b sample:a\n"
     "dispatch two store:c sample:a\n",
     "write: a none > color discard\n"
     "one: b none > color discard\n"
     "one: a color > sampled_fragment+sampled_compute\n"
     "two: c none > storage_compute discard\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n",
     "write: a sampled_fragment+sampled_compute > color discard memory\n"
     "one: b output > color discard\n"
     "one: a color > sampled_fragment+sampled_compute\n"
     "two: c output > storage_compute discard\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n"},

	{"write after read waits for all readers",
     "image a rgba8_u output\n"
     "image b rgba8_u output\n"
     "image c rgba8_u output\n"
     "draws write clear:a\n"
     "screen one fresh:b sample:a\n"
     "dispatch two store:c sample:a\n"
     "draws more over:a\n",
     "write: a none > color discard\n"
     "one: b none > color discard\n"
     "one: a color > sampled_fragment+sampled_compute\n"
     "two: c none > storage_compute discard\n"
     "more: a sampled_fragment+sampled_compute > color\n"
     "end: a color > output\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n",
     "write: a output > color discard\n"
     "one: b output > color discard\n"
     "one: a color > sampled_fragment+sampled_compute\n"
     "two: c output > storage_compute discard\n"
     "more: a sampled_fragment+sampled_compute > color\n"
     "end: a color > output\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n"},

	{"reads in two layouts, and back",
     "image a rgba8_u\n"
     "image b rgba8_u output\n"
     "image c rgba8_u output\n"
     "image d rgba8_u output\n"
     "draws write clear:a\n"
     "screen one fresh:b sample:a\n"
     "copy two from:a to:c\n"
     "screen three fresh:d sample:a\n",
     "write: a none > color discard\n"
     "one: b none > color discard\n"
     "one: a color > sampled_fragment\n"
     "two: a sampled_fragment > copy_from\n"
     "two: c none > copy_to discard\n"
     "three: d none > color discard\n"
     "three: a copy_from > sampled_fragment\n"
     "end: b color > output\n"
     "end: c copy_to > output\n"
     "end: d color > output\n",
     "write: a sampled_fragment > color discard memory\n"
     "one: b output > color discard\n"
     "one: a color > sampled_fragment\n"
     "two: a sampled_fragment > copy_from\n"
     "two: c output > copy_to discard\n"
     "three: d output > color discard\n"
     "three: a copy_from > sampled_fragment\n"
     "end: b color > output\n"
     "end: c copy_to > output\n"
     "end: d color > output\n"},

	{"an output that was copied from is ready already",
     "image a rgba8_u output\n"
     "image b rgba8_u output\n"
     "draws write clear:a\n"
     "copy again from:a to:b\n",
     "write: a none > color discard\n"
     "again: a color > copy_from+output\n"
     "again: b none > copy_to discard\n"
     "end: b copy_to > output\n",
     "write: a copy_from+output > color discard\n"
     "again: a color > copy_from+output\n"
     "again: b output > copy_to discard\n"
     "end: b copy_to > output\n"},

	{"depth before color: tested and sampled by one pass, then by a dispatch, in one layout",
     "image depth d32_f\n"
     "image color rgba8_u output\n"
     "image far rgba8_u output\n"
     "draws before clear:depth\n"
     "draws scene clear:color test:depth sample:depth\n"
     "dispatch shrink store:far sample:depth\n",
     "before: depth none > depth discard\n"
     "scene: color none > color discard\n"
     "scene: depth depth > depth_read+sampled_fragment+sampled_compute\n"
     "shrink: far none > storage_compute discard\n"
     "end: color color > output\n"
     "end: far storage_compute > output\n",
     "before: depth depth_read+sampled_fragment+sampled_compute > depth discard memory\n"
     "scene: color output > color discard\n"
     "scene: depth depth > depth_read+sampled_fragment+sampled_compute\n"
     "shrink: far output > storage_compute discard\n"
     "end: color color > output\n"
     "end: far storage_compute > output\n"},

	{"a chain of mips, each drawn from the one before, then sampled whole",
     "image a rgba8_u 8x8 mips 4\n"
     "image b rgba8_u 8x8 output\n"
     "draws m0 clear:a[0]\n"
     "screen m1 fresh:a[1] sample:a[0]\n"
     "screen m2 fresh:a[2] sample:a[1]\n"
     "screen m3 fresh:a[3] sample:a[2]\n"
     "screen all fresh:b sample:a\n",
     "m0: a[0] none > color discard\n"
     "m1: a[1] none > color discard\n"
     "m1: a[0] color > sampled_fragment\n"
     "m2: a[2] none > color discard\n"
     "m2: a[1] color > sampled_fragment\n"
     "m3: a[3] none > color discard\n"
     "m3: a[2] color > sampled_fragment\n"
     "all: b none > color discard\n"
     "all: a[3] color > sampled_fragment\n"
     "end: b color > output\n",
     "m0: a[0] sampled_fragment > color discard memory\n"
     "m1: a[1] sampled_fragment > color discard memory\n"
     "m1: a[0] color > sampled_fragment\n"
     "m2: a[2] sampled_fragment > color discard memory\n"
     "m2: a[1] color > sampled_fragment\n"
     "m3: a[3] sampled_fragment > color discard memory\n"
     "m3: a[2] color > sampled_fragment\n"
     "all: b output > color discard\n"
     "all: a[3] color > sampled_fragment\n"
     "end: b color > output\n"},

	{"six faces drawn one by one, sampled together: one barrier for all",
     "image a rgba8_u 8x8 cube\n"
     "image b rgba8_u 8x8 output\n"
     "draws f0 clear:a[0/0]\n"
     "draws f1 clear:a[0/1]\n"
     "draws f2 clear:a[0/2]\n"
     "draws f3 clear:a[0/3]\n"
     "draws f4 clear:a[0/4]\n"
     "draws f5 clear:a[0/5]\n"
     "screen all fresh:b sample:a\n",
     "f0: a[a/0] none > color discard\n"
     "f1: a[a/1] none > color discard\n"
     "f2: a[a/2] none > color discard\n"
     "f3: a[a/3] none > color discard\n"
     "f4: a[a/4] none > color discard\n"
     "f5: a[a/5] none > color discard\n"
     "all: b none > color discard\n"
     "all: a[a/a] color > sampled_fragment\n"
     "end: b color > output\n",
     "f0: a[a/0] sampled_fragment > color discard memory\n"
     "f1: a[a/1] sampled_fragment > color discard memory\n"
     "f2: a[a/2] sampled_fragment > color discard memory\n"
     "f3: a[a/3] sampled_fragment > color discard memory\n"
     "f4: a[a/4] sampled_fragment > color discard memory\n"
     "f5: a[a/5] sampled_fragment > color discard memory\n"
     "all: b output > color discard\n"
     "all: a[a/a] color > sampled_fragment\n"
     "end: b color > output\n"},

	{"all layers at once, then one layer elsewhere: the rest is one range on each side",
     "image a rgba8_u 8x8 layers 3\n"
     "image b rgba8_u 8x8 output\n"
     "draws all clear:a[0/0-2]\n"
     "copy one from:a[0/1] to:b\n"
     "screen more over:b sample:a\n",
     "all: a[a/a] none > color discard\n"
     "one: a[a/1] color > copy_from\n"
     "one: b none > copy_to discard\n"
     "more: b copy_to > color\n"
     "more: a[a/0] color > sampled_fragment\n"
     "more: a[a/1] copy_from > sampled_fragment\n"
     "more: a[a/2] color > sampled_fragment\n"
     "end: b color > output\n",
     "all: a[a/a] sampled_fragment > color discard memory\n"
     "one: a[a/1] color > copy_from\n"
     "one: b output > copy_to discard\n"
     "more: b copy_to > color\n"
     "more: a[a/0] color > sampled_fragment\n"
     "more: a[a/1] copy_from > sampled_fragment\n"
     "more: a[a/2] color > sampled_fragment\n"
     "end: b color > output\n"},

	{"mips and layers: what is left over is cut into the fewest ranges",
     "image a rgba8_u 8x8 mips 3 layers 3\n"
     "image b rgba8_u 8x8 output\n"
     "dispatch m0 store:a[0]\n"
     "dispatch m1 store:a[1]\n"
     "dispatch m2 store:a[2]\n"
     "dispatch some store:b load:a[0/0-1] load:a[1/0-1]\n"
     "screen all over:b sample:a\n",
     "m0: a[0/a] none > storage_compute discard\n"
     "m1: a[1/a] none > storage_compute discard\n"
     "m2: a[2/a] none > storage_compute discard\n"
     "some: b none > storage_compute discard\n"
     "some: a[0-1/0-1] storage_compute > storage_read_compute\n"
     "all: b storage_compute > color\n"
     "all: a[a/a] storage_read_compute+storage_compute > sampled_fragment\n"
     "end: b color > output\n",
     "m0: a[0/a] sampled_fragment > storage_compute discard memory\n"
     "m1: a[1/a] sampled_fragment > storage_compute discard memory\n"
     "m2: a[2/a] sampled_fragment > storage_compute discard memory\n"
     "some: b output > storage_compute discard\n"
     "some: a[0-1/0-1] storage_compute > storage_read_compute\n"
     "all: b storage_compute > color\n"
     "all: a[a/a] storage_read_compute+storage_compute > sampled_fragment\n"
     "end: b color > output\n"},

	{"a buffer: written by a dispatch, then commands and vertices: one barrier",
     "buffer draws 4096\n"
     "image color rgba8_u output\n"
     "dispatch cull store:draws\n"
     "draws scene clear:color indirect:draws vertices:draws\n",
     "scene: color none > color discard\n"
     "scene: draws storage_compute > vertices+indirect\n"
     "end: color color > output\n",
     "cull: draws vertices+indirect > storage_compute discard memory\n"
     "scene: color output > color discard\n"
     "scene: draws storage_compute > vertices+indirect\n"
     "end: color color > output\n"},

	{"a buffer that is added to by each dispatch, and read after the frame",
     "buffer sums 256 output\n"
     "dispatch zero store:sums\n"
     "dispatch add modify:sums\n"
     "dispatch more modify:sums\n",
     "add: sums storage_compute > storage_compute\n"
     "more: sums storage_compute > storage_compute\n"
     "end: sums storage_compute > output\n",
     "zero: sums output > storage_compute discard\n"
     "add: sums storage_compute > storage_compute\n"
     "more: sums storage_compute > storage_compute\n"
     "end: sums storage_compute > output\n"},

	{"last frame's picture, read before this frame's is written: one image does",
     "image history rgba8_u keep\n"
     "image picture rgba8_u output\n"
     "screen mix fresh:picture sample:history'\n"
     "copy save from:picture to:history\n",
     "mix: picture none > color discard\n"
     "mix: history none > sampled_fragment discard zero\n"
     "save: picture color > copy_from+output\n"
     "save: history sampled_fragment > copy_to discard\n",
     "mix: picture copy_from+output > color discard\n"
     "mix: history copy_to > sampled_fragment\n"
     "save: picture color > copy_from+output\n"
     "save: history sampled_fragment > copy_to discard\n"},

	{"many samples, resolved",
     "image many rgba16_f samples 4\n"
     "image depth d32_f samples 4\n"
     "image one rgba16_f\n"
     "image picture rgba8_srgb output\n"
     "draws scene clear:many>one clear:depth\n"
     "screen tone fresh:picture sample:one\n",
     "scene: many none > color discard\n"
     "scene: one none > resolve discard\n"
     "scene: depth none > depth discard\n"
     "tone: picture none > color discard\n"
     "tone: one resolve > sampled_fragment\n"
     "end: picture color > output\n",
     "scene: many color > color discard memory\n"
     "scene: one sampled_fragment > resolve discard memory\n"
     "scene: depth depth > depth discard memory\n"
     "tone: picture output > color discard\n"
     "tone: one resolve > sampled_fragment\n"
     "end: picture color > output\n"},

	{"an owned texture that is only read: a barrier in its first frame, and then never",
     "image grass rgba8_srgb owned 7\n"
     "image picture rgba8_u output\n"
     "draws scene clear:picture sample:grass\n",
     "scene: picture none > color discard\n"
     "scene: grass none > sampled_fragment\n"
     "end: picture color > output\n",
     "scene: picture output > color discard\n"
     "end: picture color > output\n"},

	{"owned buffers that are only read: none at all",
     "buffer mesh 4096 owned 9\n"
     "buffer rows 4096 owned 10\n"
     "image picture rgba8_u output\n"
     "draws scene clear:picture vertices:mesh load:rows\n",
     "scene: picture none > color discard\n"
     "end: picture color > output\n",
     "scene: picture output > color discard\n"
     "end: picture color > output\n"},

	{"particles: an owned buffer, moved by a dispatch and drawn",
     "buffer dust 4096 owned 3\n"
     "image picture rgba8_u output\n"
     "dispatch move modify:dust\n"
     "draws scene clear:picture load:dust\n",
     "scene: picture none > color discard\n"
     "scene: dust storage_compute > storage_read_graphics\n"
     "end: picture color > output\n",
     "move: dust storage_read_graphics > storage_compute\n"
     "scene: picture output > color discard\n"
     "scene: dust storage_compute > storage_read_graphics\n"
     "end: picture color > output\n"},

	{"three images in the memory of one: each waits for what was there",
     "image a rgba8_u\n"
     "image b rgba8_u\n"
     "image c rgba8_u\n"
     "image picture rgba8_u output\n"
     "draws one clear:a\n"
     "screen two fresh:picture sample:a\n"
     "dispatch three store:b\n"
     "screen four over:picture sample:b\n"
     "copy five from:picture to:c\n"
     "screen six fresh:picture sample:c\n",
     "one: a none > color discard\n"
     "two: picture none > color discard\n"
     "two: a color > sampled_fragment\n"
     "three: b sampled_fragment > storage_compute discard memory\n"
     "four: picture color > color\n"
     "four: b storage_compute > sampled_fragment\n"
     "five: picture color > copy_from\n"
     "five: c sampled_fragment > copy_to discard memory\n"
     "six: picture copy_from > color discard\n"
     "six: c copy_to > sampled_fragment\n"
     "end: picture color > output\n",
     "one: a sampled_fragment > color discard memory\n"
     "two: picture output > color discard\n"
     "two: a color > sampled_fragment\n"
     "three: b sampled_fragment > storage_compute discard memory\n"
     "four: picture color > color\n"
     "four: b storage_compute > sampled_fragment\n"
     "five: picture color > copy_from\n"
     "five: c sampled_fragment > copy_to discard memory\n"
     "six: picture copy_from > color discard\n"
     "six: c copy_to > sampled_fragment\n"
     "end: picture color > output\n"},

	{"shadow cascades: one array, drawn layer by layer, read by two passes",
     "image shadow d32_f 64x64 layers 2\n"
     "image depth d32_f\n"
     "image color rgba16_f\n"
     "image picture rgba8_u output\n"
     "draws near clear:shadow[0/0]\n"
     "draws far clear:shadow[0/1]\n"
     "draws scene clear:color clear:depth sample:shadow\n"
     "screen fog fresh:picture sample:color sample:shadow sample:depth\n",
     "near: shadow[a/0] none > depth discard\n"
     "far: shadow[a/1] none > depth discard\n"
     "scene: color none > color discard\n"
     "scene: depth none > depth discard\n"
     "scene: shadow[a/a] depth > sampled_fragment\n"
     "fog: picture none > color discard\n"
     "fog: color color > sampled_fragment\n"
     "fog: depth depth > sampled_fragment\n"
     "end: picture color > output\n",
     "near: shadow[a/0] sampled_fragment > depth discard memory\n"
     "far: shadow[a/1] sampled_fragment > depth discard memory\n"
     "scene: color sampled_fragment > color discard memory\n"
     "scene: depth sampled_fragment > depth discard memory\n"
     "scene: shadow[a/a] depth > sampled_fragment\n"
     "fog: picture output > color discard\n"
     "fog: color color > sampled_fragment\n"
     "fog: depth depth > sampled_fragment\n"
     "end: picture color > output\n"},

	{"an array of which only some is written: the rest is no output",
     "image a rgba8_u 8x8 layers 4 mips 2 output\n"
     "draws one clear:a[0/1]\n"
     "draws two clear:a[0/2]\n"
     "draws three clear:a[1/2]\n",
     "one: a[0/1] none > color discard\n"
     "two: a[0/2] none > color discard\n"
     "three: a[1/2] none > color discard\n"
     "end: a[0/1-2] color > output\n"
     "end: a[1/2] color > output\n",
     "one: a[0/1] output > color discard\n"
     "two: a[0/2] output > color discard\n"
     "three: a[1/2] output > color discard\n"
     "end: a[0/1-2] color > output\n"
     "end: a[1/2] color > output\n"},

	{"a layout in between: what last frame's barriers named is not ready any more",
     "image grass rgba8_u owned 7\n"
     "image b rgba8_u output\n"
     "image c rgba8_u output\n"
     "screen one fresh:b sample:grass\n"
     "copy two from:grass to:c\n"
     "screen three over:b sample:grass\n"
     "dispatch four modify:c sample:grass\n",
     "one: b none > color discard\n"
     "one: grass none > sampled_fragment\n"
     "two: grass sampled_fragment > copy_from\n"
     "two: c none > copy_to discard\n"
     "three: b color > color\n"
     "three: grass copy_from > sampled_fragment+sampled_compute\n"
     "four: c copy_to > storage_compute\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n",
     "one: b output > color discard\n"
     "two: grass sampled_fragment+sampled_compute > copy_from\n"
     "two: c output > copy_to discard\n"
     "three: b color > color\n"
     "three: grass copy_from > sampled_fragment+sampled_compute\n"
     "four: c copy_to > storage_compute\n"
     "end: b color > output\n"
     "end: c storage_compute > output\n"},
};

static void expect(const stilb_gpu_plan *plan, const example *row, uint32_t frame)
{
	char *found = script_barriers(plan);
	const char *wanted = frame == 0 || !row->next ? row->first : row->next;
	if (strcmp(found, wanted) != 0)
		fail_msg("%s: frame %u has\n%sand not\n%s", row->what, frame, found, wanted);
	free(found);
}

static void test_lists(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
		stilb_gpu_plan *plan = stilb_gpu_plan_create();
		for (uint32_t frame = 0; frame < 4; frame++) {
			script_make(plan, examples[i].rows);
			expect(plan, &examples[i], frame);
		}
		stilb_gpu_plan_destroy(plan);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_lists)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
