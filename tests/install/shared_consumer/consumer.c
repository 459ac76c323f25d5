/* consumer PLUGIN: a program against libstilb.so. Its zones, in C, in C++ and in a shared object that it loads and
 * closes, lie in one timeline with the engine's. */
#include <stilb/engine.h>
#include <stilb/job_prof.h>
#include <stilb/prof_snapshot.h>

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

void zone_in_cpp(void);

STILB_PROF_FLOW(order, "order", 0);
static uint64_t ordered;

static void *work(void *plugin)
{
	PROFILE("on a thread");
	stilb_prof_flow_end(order, ordered);
	void (*zone)(void) = (void (*)(void))dlsym(plugin, "zone_in_plugin");
	if (zone)
		zone();
	return NULL;
}

static void on_update(void *user, const stilb_engine_update *update)
{
	(void)user;
	PROFILE("in update");
	PROFILE_COUNTER("frames", (double)update->frame);
}

static int has(const stilb_prof_snapshot *snapshot, const char *name)
{
	for (uint32_t l = 0; l < snapshot->label_count; l++)
		if (strcmp(snapshot->labels[l].name, name) == 0)
			for (uint32_t lane = 0; lane < snapshot->lane_count; lane++)
				for (uint32_t z = 0; z < snapshot->lanes[lane].zone_count; z++)
					if (snapshot->lanes[lane].zones[z].label == l)
						return 1;
	printf("no zone \"%s\"\n", name);
	return 0;
}

/* Every zone stands among the sites that can be walked; each once. */
static int walked(const char *name)
{
	int found = 0;
	for (const stilb_prof_site *site = stilb_prof_site_next(NULL); site; site = stilb_prof_site_next(site))
		found += strcmp(site->name, name) == 0;
	if (found != 1)
		printf("\"%s\" is walked %d times\n", name, found);
	return found == 1;
}

static int check(void)
{
	static const char *const names[] = {"in update",   "scene update", "on a thread", "in C++",
	                                    "in a plugin", "made",         "by hand"};
	stilb_prof_snapshot snapshot = {0};
	int wrong = stilb_prof_snapshot_take(&snapshot, NULL) != 0;
	for (unsigned i = 0; i < sizeof names / sizeof *names; i++)
		wrong += !has(&snapshot, names[i]) || !walked(names[i]);
	uint32_t points = 0;
	for (uint32_t i = 0; i < snapshot.point_count; i++)
		points += strcmp(snapshot.labels[snapshot.points[i].label].name, "frames") == 0 &&
		          snapshot.points[i].value == (double)(points + 1);
	wrong += points != 5;
	int arrows = 0;
	for (uint32_t i = 0; i < snapshot.flow_count; i++)
		arrows += strcmp(snapshot.labels[snapshot.flows[i].label].name, "order") == 0 &&
		          snapshot.flows[i].from_lane != snapshot.flows[i].to_lane &&
		          snapshot.flows[i].to_lane != STILB_PROF_NONE;
	wrong += arrows != 1;
	if (!wrong)
		printf("one timeline\n");
	else
		printf("%d wrong, %u counted, %d arrows\n", wrong, points, arrows);
	stilb_prof_snapshot_finish(&snapshot);
	return wrong;
}

int main(int argc, char **argv)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 2;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.update = on_update;
	stilb_engine *engine;
	stilb_engine_report report = {0};
	void *plugin = argc > 1 ? dlopen(argv[1], RTLD_NOW) : NULL;
	if (!plugin || stilb_engine_create(&desc, &engine) != STILB_OK) {
		printf("%s\n", plugin ? stilb_error_message() : dlerror());
		return 1;
	}
	while (report.frame < 5 && stilb_engine_frame(engine, &report) == STILB_OK)
		zone_in_cpp();
	{
		stilb_prof_zone_begin(
			stilb_prof_site_make("made", 0)); /* a site in the library, written by code of the program */
		ordered = stilb_prof_flow_begin(order);
		stilb_prof_zone_end();
		PROFILE_BEGIN("by hand");
		PROFILE_END();
	}
	pthread_t thread;
	if (pthread_create(&thread, NULL, work, plugin) == 0)
		pthread_join(thread, NULL);
	dlclose(plugin); /* its zones remain to be shown */
	int wrong = check();
	stilb_engine_destroy(engine);
	return wrong != 0;
}
