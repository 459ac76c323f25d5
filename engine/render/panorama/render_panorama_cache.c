/* What highlights mirror of a panorama, on disk. */
#include "base/base_cache.h"
#include "render/panorama/render_panorama_work.h"

#include <string.h>

/* Counts up with every change of what numeric_prefilter.c and numeric_dfg.c make of the same cells, or of the file. */
#define CACHE_VERSION 1u

static const stilb_cache cache_panoramas = {"panoramas", ".panorama", 64u << 20};

typedef struct cache_header {
	char magic[8];
	uint32_t version, endian;
	uint64_t key[2];
	uint64_t checksum[2]; /* of the rest of the file: the cube, then the table */
} cache_header;

#define CACHE_CUBE (sizeof(uint16_t[4]) * RENDER_PANORAMA_CUBE)
#define CACHE_TABLE sizeof(cache_table)

typedef uint16_t cache_table[RENDER_PANORAMA_DFG][RENDER_PANORAMA_DFG][2];

static cache_header cache_header_of(const render_panorama_work *work, const cache_table *table)
{
	cache_header header = {
		.magic = "STILBPN", .version = CACHE_VERSION, .endian = 1, .key = {work->cells_key[0], work->cells_key[1]}};
	stilb_cache_hash hash = stilb_cache_hash_start();
	stilb_cache_hash_add(&hash, work->cube, CACHE_CUBE);
	stilb_cache_hash_add(&hash, table, CACHE_TABLE);
	stilb_cache_hash_end(&hash, header.checksum);
	return header;
}

static void cache_key(render_panorama_work *work)
{
	static const uint32_t numbers[] = {CACHE_VERSION,        PANORAMA_ACROSS,      PANORAMA_DOWN,
	                                   RENDER_PANORAMA_FACE, RENDER_PANORAMA_MIPS, RENDER_PANORAMA_DFG};
	stilb_cache_hash hash = stilb_cache_hash_start();
	stilb_cache_hash_add(&hash, numbers, sizeof numbers);
	stilb_cache_hash_add(&hash, work->cells, PANORAMA_DOWN * sizeof *work->cells);
	stilb_cache_hash_end(&hash, work->cells_key);
}

bool render_panorama_cache_find(render_panorama_work *work)
{
	cache_header header;
	cache_table table; /* the work's may be shown already */
	cache_key(work);
	FILE *stream = stilb_cache_open(&cache_panoramas, work->cells_key);
	if (!stream)
		return false;
	bool read = fread(&header, sizeof header, 1, stream) == 1 && fread(work->cube, CACHE_CUBE, 1, stream) == 1 &&
	            fread(table, CACHE_TABLE, 1, stream) == 1 && fgetc(stream) == EOF;
	fclose(stream);
	if (!read)
		return false;
	cache_header wanted = cache_header_of(work, &table);
	if (memcmp(&header, &wanted, sizeof header) != 0)
		return false; /* it is damaged, or of another version */
	memcpy(work->dfg, table, sizeof table);
	stilb_cache_used(&cache_panoramas, work->cells_key);
	return true;
}

void render_panorama_cache_keep(const render_panorama_work *work)
{
	stilb_file file;
	if (!stilb_cache_begin(&cache_panoramas, work->cells_key, &file))
		return;
	cache_header header = cache_header_of(work, (const cache_table *)(const void *)work->dfg);
	bool written = stilb_file_write(&file, &header, sizeof header) == 0 &&
	               stilb_file_write(&file, work->cube, CACHE_CUBE) == 0 &&
	               stilb_file_write(&file, work->dfg, CACHE_TABLE) == 0;
	stilb_cache_end(&cache_panoramas, &file, written);
}
