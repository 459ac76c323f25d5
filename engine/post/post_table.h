/*
 * post_table: tables of colours for grading, from files of the format Cube LUT 1.0 (.cube), which programs for film and
 * photographs write.
 *
 * Meaning   What is looked up, and what stands there, are codes of sRGB over 255. In a cube of size^3 colours it is
 *           linear in each of six tetrahedra of a cell; of curves, one a channel, between two entries. Outside of the
 *           domain the nearest entry counts.
 * Format    Lines of at most 250 bytes of text; blank ones and those that begin with # are comments. TITLE "text",
 *           LUT_3D_SIZE 2..256 or LUT_1D_SIZE 2..65536, DOMAIN_MIN and DOMAIN_MAX with three numbers each (0 and 1),
 *           or LUT_3D_INPUT_RANGE, LUT_1D_INPUT_RANGE with two, as other programs write; then as many lines of three
 *           finite numbers as there are colours, red fastest.
 * Source    Adobe, "Cube LUT Specification Version 1.0" (2013).
 * Example.
 *
 *   stilb_post_table *table;
 *   stilb_result result = stilb_post_table_open("warm.cube", &table);
 *   if (result == STILB_OK)
 *       result = stilb_engine_set_grade(engine, table, NULL, 0);
 *   stilb_post_table_destroy(table);
 *
 * Threads   [any-thread] for tables that nobody destroys.
 */
#ifndef STILB_POST_TABLE_H
#define STILB_POST_TABLE_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_POST_TABLE_CUBE 256u     /* entries a side, at most */
#define STILB_POST_TABLE_CURVES 65536u /* of curves */

typedef struct stilb_post_table {
	uint32_t size;         /* entries a side, 2..256; curves: 2..65,536 */
	bool curves;           /* each channel has a curve of its own, and depends on nothing else */
	float low[3], high[3]; /* what the first and the last entry are for */
	char title[256];       /* "": none */
	float *values;         /* [size^3][3], red fastest; curves: [size][3] */
} stilb_post_table;

/* Reads a file. STILB_ERROR_FILE: it cannot be read, or is no such table; the message has the line. STILB_ERROR_MEMORY:
 * the message has the table's size. *table is NULL then. */
stilb_result stilb_post_table_open(const char *path, stilb_post_table **table);

/* The same of size bytes of text; name: what messages call it. */
stilb_result stilb_post_table_parse(const char *name, const char *text, size_t size, stilb_post_table **table);

/* A cube, 2..256, that shows each colour as it is. STILB_ERROR_MEMORY. */
stilb_result stilb_post_table_identity(uint32_t size, stilb_post_table **table);

/* Accepts NULL. */
void stilb_post_table_destroy(stilb_post_table *table);

/* What the table has for these codes. */
void stilb_post_table_at(const stilb_post_table *table, const float code[3], float out[3]);

/* True if it shows each colour between 0 and 1 as it is, to a thousandth of a code. */
bool stilb_post_table_is_identity(const stilb_post_table *table);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
