#include "jobs/job_record.h"

struct job_record_slab {
	job_record_slab *next;
	alignas(64) job_record record[JOB_RECORD_SLAB];
};

void job_record_store_init(job_record_store *store, const stilb_job_allocator *memory)
{
	store->memory = memory;
	atomic_init(&store->spare, NULL);
	atomic_init(&store->slabs, NULL);
}

void job_record_store_finish(job_record_store *store)
{
	/* Acquire pairs with slab_create. */
	job_record_slab *slab = atomic_exchange_explicit(&store->slabs, NULL, memory_order_acquire);
	while (slab) {
		job_record_slab *next = slab->next;
		job_release(store->memory, slab, sizeof *slab);
		slab = next;
	}
}

static job_record *slab_create(job_record_store *store)
{
	job_record_slab *slab = job_allocate(store->memory, sizeof *slab, alignof(job_record_slab));
	if (!slab)
		return NULL;
	for (uint32_t i = 0; i < JOB_RECORD_SLAB; i++) {
		slab->record[i].next = i + 1 < JOB_RECORD_SLAB ? &slab->record[i + 1] : NULL;
		slab->record[i].tag = 0;
		atomic_init(&slab->record[i].root, 0);
		atomic_init(&slab->record[i].level, 0);
	}
	slab->next = atomic_load_explicit(&store->slabs, memory_order_relaxed); /* the first guess of the exchange */
	/* Release pairs with the acquire in job_record_store_finish. */
	while (!atomic_compare_exchange_weak_explicit(&store->slabs, &slab->next, slab, memory_order_release,
	                                              memory_order_relaxed))
		;
	return slab->record;
}

/* For asserts: the list `given` of the cache has given_count records and ends with given_last. */
static bool cache_is_sound(const job_record_cache *cache)
{
	uint32_t count = 0;
	const job_record *last = NULL;
	for (const job_record *record = cache->given; record && count <= JOB_RECORD_LIST; record = record->next) {
		last = record;
		count++;
	}
	return count == cache->given_count && (count == 0 || last == cache->given_last);
}

job_record *job_record_take_other(job_record_store *store, job_record_cache *cache)
{
	assert(!cache->given && cache->given_count == 0);
	/* The relaxed load only saves the exchange if the store seems empty. If its value is old, the thread allocates
	 * although there are spare records, or exchanges in vain; both do no harm. */
	if (!cache->taken && atomic_load_explicit(&store->spare, memory_order_relaxed))
		cache->taken =
			atomic_exchange_explicit(&store->spare, NULL, memory_order_acquire); /* pairs with job_record_spill */
	if (!cache->taken)
		cache->taken = slab_create(store);
	job_record *record = cache->taken;
	if (record)
		cache->taken = record->next;
	return record;
}

void job_record_spill(job_record_store *store, job_record_cache *cache)
{
	JOB_CHECK(cache_is_sound(cache));
	job_record *first = cache->given, *last = cache->given_last;
	last->next = atomic_load_explicit(&store->spare, memory_order_relaxed); /* the first guess of the exchange */
	/* Release pairs with the acquire in job_record_take: the links of the list. */
	while (!atomic_compare_exchange_weak_explicit(&store->spare, &last->next, first, memory_order_release,
	                                              memory_order_relaxed))
		;
	cache->given = NULL;
	cache->given_count = 0;
}
