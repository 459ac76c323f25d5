/* Tables of colours: what files say, what is wrong with them, and colours between entries beside the same in double. */
#include "post/post_table.h"
#include "support/test.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_post_table *table_of(const char *text)
{
	stilb_post_table *table;
	if (stilb_post_table_parse("t.cube", text, strlen(text), &table) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return table;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void files_say_tables(void **state)
{
	(void)state;
	stilb_post_table *t = table_of("# a comment\r\n"
	                               "TITLE \"two # by two\"\r\n"
	                               "\r\n"
	                               "  LUT_3D_SIZE  2 \r\n"
	                               "DOMAIN_MIN 0 -1 0.5\r\n"
	                               "DOMAIN_MAX 1 1 2e0\r\n"
	                               "0 0 0\r\n1 0 0\r\n# in between\r\n0 1 0\r\n1 1 0\r\n"
	                               "0 0 1\r\n1 0 1\r\n0 1 1\r\n-.5 +1.5 1e-3\r\n\r\n");
	assert_string_equal(t->title, "two # by two");
	assert_true(t->size == 2 && !t->curves);
	assert_true(t->low[0] == 0.0f && t->low[1] == -1.0f && t->low[2] == 0.5f);
	assert_true(t->high[0] == 1.0f && t->high[1] == 1.0f && t->high[2] == 2.0f);
	assert_true(t->values[3] == 1.0f && t->values[4] == 0.0f); /* red is fastest */
	assert_true(t->values[7] == 1.0f && t->values[6] == 0.0f && t->values[14] == 1.0f);
	assert_true(t->values[21] == -0.5f && t->values[22] == 1.5f && t->values[23] == 1e-3f);
	stilb_post_table_destroy(t);
	t = table_of("LUT_1D_SIZE 3\nLUT_1D_INPUT_RANGE -0.5 2\n0 0 1\n0.5 0.25 0.5\n1 1 0");
	assert_true(t->size == 3 && t->curves && t->low[2] == -0.5f && t->high[0] == 2.0f && t->title[0] == '\0');
	stilb_post_table_destroy(t);
	stilb_post_table_destroy(NULL);
	/* Points are points in each locale. */
	if (setlocale(LC_NUMERIC, "de_DE.UTF-8"))
		stilb_post_table_destroy(table_of("LUT_1D_SIZE 2\n0.5 0 0\n1.5 1 1"));
	setlocale(LC_NUMERIC, "C");
}

static void bad_files_are_told_by_line(void **state)
{
	(void)state;
	static const struct {
		const char *text, *words;
	} cases[] = {
		{"", "it has no LUT_3D_SIZE and no LUT_1D_SIZE"},
		{"PNG", "line 1: it begins with no word"},
		{"TITLE none\n", "line 1: TITLE is no text in quotes"},
		{"\n\nLUT_3D_SIZE 257\n", "line 3: LUT_3D_SIZE is not in 2..256"},
		{"LUT_3D_SIZE 1\n", "line 1: LUT_3D_SIZE"},
		{"LUT_3D_SIZE -2\n", "line 1: LUT_3D_SIZE"},
		{"LUT_3D_SIZE 2 2\n", "line 1: LUT_3D_SIZE"},
		{"LUT_3D_SIZE\n", "line 1: LUT_3D_SIZE"},
		{"LUT_1D_SIZE 65537\n", "line 1: LUT_1D_SIZE is not a number in 2..65536"},
		{"LUT_1D_SIZE 99999999999999999999999\n", "line 1: LUT_1D_SIZE"},
		{"LUT_3D_SIZE 2\nLUT_1D_SIZE 2\n", "line 2: the size was given before"},
		{"0 0 0\n", "line 1: colours come behind LUT_3D_SIZE"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 1\n", "line 3: a colour is three finite numbers"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 1 1 1\n", "line 3: a colour is"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 nan 1\n", "line 3: a colour is"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 1e999 1\n", "line 3: a colour is"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 1 1x\n", "line 3: a colour is"},
		{"LUT_1D_SIZE 2\n0 0 0\n1 1 1\n1 1 1\n", "line 4: there are more colours"},
		{"LUT_1D_SIZE 2\n0 0 0\n", "line 2: it ends after 1 of 2 colours"},
		{"LUT_1D_SIZE 2\n0 0 0\nTITLE \"late\"\n1 1 1\n", "line 3: words come before the colours"},
		{"DOMAIN_MIN 0 0\n", "line 1: the domain's end is not three numbers"},
		{"DOMAIN_MIN 0 0 0\nDOMAIN_MIN 0 0 0\n", "line 2: this end of the domain was given before"},
		{"DOMAIN_MAX 1 1 1\nLUT_3D_INPUT_RANGE 0 1\n", "line 2: the domain was given before"},
		{"LUT_3D_INPUT_RANGE 0\n", "line 1: the range is not two numbers"},
		{"LUT_1D_SIZE 2\nDOMAIN_MAX 1 0 1\n0 0 0\n1 1 1\n", "DOMAIN_MIN 0 is not below DOMAIN_MAX 0"},
		{"LUT_1D_SIZES 2\n", "line 1: it begins with no word"},
	};
	stilb_post_table *t;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		assert_int_equal(stilb_post_table_parse("t.cube", cases[i].text, strlen(cases[i].text), &t), STILB_ERROR_FILE);
		assert_null(t);
		if (strncmp(stilb_error_message(), "t.cube: ", 8) != 0 || !strstr(stilb_error_message(), cases[i].words))
			fail_msg("'%s' instead of '%s'", stilb_error_message(), cases[i].words);
	}
	char line[400];
	memset(line, ' ', sizeof line);
	line[0] = line[sizeof line - 2] = 'x';
	line[sizeof line - 1] = '\0';
	assert_int_equal(stilb_post_table_parse("t.cube", line, strlen(line), &t), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "line 1: it is no text of at most 250 bytes"));
	assert_int_equal(stilb_post_table_open("no such file.cube", &t), STILB_ERROR_FILE);
}

/* Bytes that change, go and come: a table or a message, and nothing else. */
static void damaged_files_are_answered(void **state)
{
	(void)state;
	static const char good[] = "TITLE \"t\"\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n0 0 0\n1 0 0\n0 1 0\n"
							   "1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
	uint32_t tables = 0;
	for (uint64_t i = 0; i < 20000; i++) {
		char text[sizeof good];
		size_t size = sizeof good - 1;
		memcpy(text, good, sizeof good);
		for (uint64_t m = 0; m < 1 + i % 3; m++)
			text[stilb_random_u64(i, 3 * m) % size] =
				(i % 2 ? (char)stilb_random_u64(i, 3 * m + 1)
			           : good[stilb_random_u64(i, 3 * m + 1) % (sizeof good - 1)]);
		if (i % 4 == 0)
			size = stilb_random_u64(i, 99) % size;
		stilb_post_table *t;
		stilb_result result = stilb_post_table_parse("t.cube", text, size, &t);
		assert_true((result == STILB_OK) == (bool)t);
		tables += (bool)t;
		stilb_post_table_destroy(t);
	}
	print_message("%u of 20,000 are tables all the same\n", tables);
	assert_true(tables > 100 && tables < 19900);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static stilb_post_table *random_table(uint64_t seed, uint32_t size, bool curves)
{
	stilb_post_table *t;
	uint32_t count = curves ? size : size * size * size;
	assert_int_equal(stilb_post_table_identity(curves ? 2 : size, &t), STILB_OK);
	free(t->values);
	t->size = size;
	t->curves = curves;
	t->values = malloc((size_t)count * 3 * sizeof *t->values);
	assert_non_null(t->values);
	for (uint32_t i = 0; i < 3 * count; i++)
		t->values[i] = 1.5f * stilb_random_float(seed, i) - 0.25f;
	for (uint32_t c = 0; c < 3; c++) {
		t->low[c] = -0.5f * stilb_random_float(seed + 1, c);
		t->high[c] = 1.0f + stilb_random_float(seed + 2, c);
	}
	return t;
}

/* Where a code lies among the entries, in double. */
static void place_of(const stilb_post_table *t, const float code[3], uint32_t first[3], double beside[3])
{
	for (int c = 0; c < 3; c++) {
		double low = (double)t->low[c], high = (double)t->high[c], last = t->size - 1.0;
		double at = fmin(fmax(((double)code[c] - low) / (high - low), 0.0), 1.0) * last;
		first[c] = (uint32_t)fmin(floor(at), last - 1.0);
		beside[c] = at - first[c];
	}
}

static double entry_of(const stilb_post_table *t, const uint32_t first[3], uint32_t corner, uint32_t channel)
{
	uint32_t r = first[0] + (corner & 1), g = first[1] + (corner >> 1 & 1), b = first[2] + (corner >> 2);
	return (double)t->values[3 * (((size_t)b * t->size + g) * t->size + r) + channel];
}

/* The six tetrahedra, as printed: by the order of the three shares. */
static double tetrahedral(const stilb_post_table *t, const uint32_t first[3], const double d[3], uint32_t channel)
{
	double r = d[0], g = d[1], b = d[2], v[8];
	for (uint32_t i = 0; i < 8; i++)
		v[i] = entry_of(t, first, i, channel);
	if (r >= g && g >= b)
		return (1 - r) * v[0] + (r - g) * v[1] + (g - b) * v[3] + b * v[7];
	if (r >= b && b >= g)
		return (1 - r) * v[0] + (r - b) * v[1] + (b - g) * v[5] + g * v[7];
	if (b >= r && r >= g)
		return (1 - b) * v[0] + (b - r) * v[4] + (r - g) * v[5] + g * v[7];
	if (b >= g && g >= r)
		return (1 - b) * v[0] + (b - g) * v[4] + (g - r) * v[6] + r * v[7];
	if (g >= b && b >= r)
		return (1 - g) * v[0] + (g - b) * v[2] + (b - r) * v[6] + r * v[7];
	return (1 - g) * v[0] + (g - r) * v[2] + (r - b) * v[3] + b * v[7];
}

static double trilinear(const stilb_post_table *t, const uint32_t first[3], const double d[3], uint32_t channel)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < 8; i++)
		sum += entry_of(t, first, i, channel) * (i & 1 ? d[0] : 1 - d[0]) * (i & 2 ? d[1] : 1 - d[1]) *
		       (i & 4 ? d[2] : 1 - d[2]);
	return sum;
}

static void colours_are_as_in_double(void **state)
{
	(void)state;
	static const uint32_t sizes[] = {2, 3, 17, 33};
	for (uint32_t s = 0; s < 8; s++) {
		bool curves = s >= 4;
		stilb_post_table *t = random_table(40 + s, sizes[s % 4], curves);
		for (uint64_t i = 0; i < 5000; i++) {
			float code[3], got[3];
			double beside[3];
			uint32_t first[3];
			for (uint64_t c = 0; c < 3; c++) /* also beyond the domain, and equal ones */
				code[c] = i % 5 == 0 && c > 0 ? code[0] : 4.0f * stilb_random_float(9, 3 * i + c) - 1.5f;
			stilb_post_table_at(t, code, got);
			place_of(t, code, first, beside);
			for (uint32_t c = 0; c < 3; c++) {
				double low = curves ? (double)t->values[3 * first[c] + c] : 0.0;
				double want = curves ? low + beside[c] * ((double)t->values[3 * first[c] + 3 + c] - low)
				                     : tetrahedral(t, first, beside, c);
				assert_true(fabs((double)got[c] - want) < 1e-5 * t->size);
			}
		}
		assert_false(stilb_post_table_is_identity(t));
		stilb_post_table_destroy(t);
	}
}

static void identities_show_what_is_there(void **state)
{
	(void)state;
	for (uint32_t size = 2; size <= 65; size++) {
		stilb_post_table *t;
		assert_int_equal(stilb_post_table_identity(size, &t), STILB_OK);
		assert_true(stilb_post_table_is_identity(t));
		for (uint64_t i = 0; i < 2000; i++) {
			float code[3] = {stilb_random_float(3, 3 * i), stilb_random_float(3, 3 * i + 1), (float)(i % 256) / 255.0f};
			float got[3];
			stilb_post_table_at(t, code, got);
			for (int c = 0; c < 3; c++)
				assert_true(fabsf(got[c] - code[c]) <= 2e-7f);
		}
		t->values[3 * (size - 1)] -= 1e-4f;
		assert_false(stilb_post_table_is_identity(t));
		stilb_post_table_destroy(t);
	}
	stilb_post_table *curve = table_of("LUT_1D_SIZE 3\nLUT_1D_INPUT_RANGE -1 3\n-1 -1 -1\n1 1 1\n3 3 3");
	assert_true(stilb_post_table_is_identity(curve));
	curve->low[1] = -0.9f;
	assert_false(stilb_post_table_is_identity(curve));
	stilb_post_table_destroy(curve);
}

/* ---- why tetrahedra ---------------------------------------------------------------------------------------------- */

#define GRADES 4

/* Grades as films have them: warm, cold, contrast by brightness, hues turned. */
static void grade_of(int number, const double in[3], double out[3])
{
	double y = 0.2126 * in[0] + 0.7152 * in[1] + 0.0722 * in[2], c[3];
	for (int k = 0; k < 3; k++)
		c[k] = y + (in[k] - y) * (number == 0 ? 0.65 : number == 1 ? 0.35 : 1.3);
	if (number == 0) {
		out[0] = pow(c[0], 0.85) * 1.03;
		out[1] = pow(c[1], 0.97);
		out[2] = pow(c[2], 1.25) * 0.92;
	} else if (number == 1) {
		out[0] = pow(c[0], 1.15) * 0.9;
		out[1] = c[1];
		out[2] = pow(c[2], 0.85) * 0.97 + 0.03;
	} else if (number == 2) {
		for (int k = 0; k < 3; k++)
			out[k] = y * y * (3.0 - 2.0 * y) + c[k] - y;
	} else {
		double cosine = cos(0.5), sine = sin(0.5) / sqrt(3.0), rest = (1.0 - cosine) / 3.0;
		for (int k = 0; k < 3; k++)
			out[k] = (cosine + rest) * in[k] + (rest - sine) * in[(k + 1) % 3] + (rest + sine) * in[(k + 2) % 3];
	}
	for (int k = 0; k < 3; k++)
		out[k] = fmin(fmax(out[k], 0.0), 1.0);
}

static stilb_post_table *grade_table(int number, uint32_t size)
{
	stilb_post_table *t;
	assert_int_equal(stilb_post_table_identity(size, &t), STILB_OK);
	for (size_t i = 0; i < (size_t)size * size * size; i++) {
		double in[3], out[3];
		for (int c = 0; c < 3; c++)
			in[c] = (double)t->values[3 * i + c];
		grade_of(number, in, out);
		for (int c = 0; c < 3; c++)
			t->values[3 * i + c] = (float)out[c];
	}
	return t;
}

/* Over four grades tetrahedra are as near to them as cells of eight corners are, and near grey nearer by a fifth. */
static void tetrahedra_are_nearer(void **state)
{
	(void)state;
	for (uint32_t size = 17; size <= 33; size += 16)
		for (int grey = 0; grey < 2; grey++) {
			double tetra = 0.0, cells = 0.0;
			for (int g = 0; g < GRADES; g++) {
				stilb_post_table *t = grade_table(g, size);
				for (uint64_t i = 0; i < 20000; i++) {
					float code[3];
					double want[3], in[3], beside[3];
					uint32_t first[3];
					for (uint64_t c = 0; c < 3; c++) {
						float any = stilb_random_float(60, 4 * i + c), y = stilb_random_float(60, 4 * i + 3);
						code[c] = grey ? fminf(fmaxf(y + 0.05f * (any - 0.5f), 0.0f), 1.0f) : any;
						in[c] = (double)code[c];
					}
					grade_of(g, in, want);
					place_of(t, code, first, beside);
					for (uint32_t c = 0; c < 3; c++) {
						tetra += pow(tetrahedral(t, first, beside, c) - want[c], 2.0);
						cells += pow(trilinear(t, first, beside, c) - want[c], 2.0);
					}
				}
				stilb_post_table_destroy(t);
			}
			double count = GRADES * 60000.0;
			print_message("size %u, %s: off by %.3f codes by tetrahedra, %.3f by cells\n", size,
			              grey ? "near grey" : "all colours", 255.0 * sqrt(tetra / count), 255.0 * sqrt(cells / count));
			assert_true(sqrt(tetra) < (grey ? 0.8 : 1.03) * sqrt(cells));
		}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(files_say_tables),
		cmocka_unit_test(bad_files_are_told_by_line),
		cmocka_unit_test(damaged_files_are_answered),
		cmocka_unit_test(colours_are_as_in_double),
		cmocka_unit_test(identities_show_what_is_there),
		cmocka_unit_test(tetrahedra_are_nearer),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
