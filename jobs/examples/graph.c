/*
 * A graph of jobs, built once and run each frame: cull -> (shadows, scene) -> show. Shadows and the scene are drawn at
 * the same time. Then an edge back to the beginning, which build refuses with the names of those who wait for one
 * another.
 *
 * Prints: 100 frames, each shown complete: yes; then: cull -> scene -> cull
 */
#include <stilb/job_graph.h>

#include <stdio.h>

typedef struct frame {
	int number, culled, shadowed, drawn, complete;
} frame;

static void cull(void *data, uint32_t worker)
{
	(void)worker;
	frame *f = data;
	f->culled = f->number;
}

static void draw_shadows(void *data, uint32_t worker)
{
	(void)worker;
	frame *f = data;
	f->shadowed = f->culled;
}

static void draw_scene(void *data, uint32_t worker)
{
	(void)worker;
	frame *f = data;
	f->drawn = f->culled;
}

static void show(void *data, uint32_t worker)
{
	(void)worker;
	frame *f = data;
	f->complete += f->shadowed == f->number && f->drawn == f->number;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	stilb_job_graph *graph;
	if (stilb_job_pool_create(&desc, &pool) != 0 || stilb_job_graph_create(&graph) != 0)
		return 1;
	frame f = {0};
	uint32_t first, shadows, scene, last;
	int errors = stilb_job_graph_add_node(graph, cull, &f, "cull", &first) != 0;
	errors += stilb_job_graph_add_node(graph, draw_shadows, &f, "shadows", &shadows) != 0;
	errors += stilb_job_graph_add_node(graph, draw_scene, &f, "scene", &scene) != 0;
	errors += stilb_job_graph_add_node(graph, show, &f, "show", &last) != 0;
	if (errors > 0) /* numbers of nodes are not set */
		return 1;
	errors += stilb_job_graph_add_edge(graph, first, shadows) != 0;
	errors += stilb_job_graph_add_edge(graph, first, scene) != 0;
	errors += stilb_job_graph_add_edge(graph, shadows, last) != 0;
	errors += stilb_job_graph_add_edge(graph, scene, last) != 0;
	char cycle[100];
	errors += stilb_job_graph_build(graph, cycle, sizeof cycle) != 0;
	for (f.number = 1; f.number <= 100 && errors == 0; f.number++) {
		stilb_job_group group = {0};
		errors += stilb_job_graph_run(graph, pool, &group, 0) != 0;
		stilb_job_wait(pool, &group, 0);
	}
	printf("%d frames, each shown complete: %s; ", f.number - 1, f.complete == f.number - 1 ? "yes" : "no");
	errors += stilb_job_graph_add_edge(graph, scene, first) != 0;
	errors += stilb_job_graph_build(graph, cycle, sizeof cycle) == 0;
	printf("then: %s\n", cycle);
	stilb_job_graph_destroy(graph);
	stilb_job_pool_destroy(pool);
	return errors;
}
