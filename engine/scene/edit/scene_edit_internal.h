/* The state of a scene's edits: capacities of its arrays, free ids, who names what, and what has changed. */
#ifndef STILB_SCENE_EDIT_INTERNAL_H
#define STILB_SCENE_EDIT_INTERNAL_H

#include "jobs/job.h"
#include "scene/edit/scene_edit.h"

#define EDIT_IN_USE UINT32_MAX /* in place of the next free id */
#define EDIT_BUCKETS 64u       /* lists of free models, by the low bits of their part count */
#define EDIT_MOST_RANGES 4096u /* of changed vertices; beyond it whole meshes are listed */

/* An array that grows with others. */
typedef struct edit_array {
	void **at;      /* where its pointer is */
	size_t element; /* bytes */
	uint32_t extra; /* elements that it has beyond the number of the others */
} edit_array;

/* Ids of one kind, other than models. */
typedef struct edit_ids {
	const char *name;    /* "mesh" */
	uint32_t capacity;   /* of the scene's array of this kind, and of those below */
	uint32_t first_free; /* 1 + an id; 0: none is free */
	uint32_t *next;      /* [capacity] of a free id: 1 + the next free one, 0: it is the last; else EDIT_IN_USE */
	uint32_t *users;     /* [capacity] how many parts, materials or surfaces name it */
	uint32_t *changed;   /* [changed_count] the ids that have changed, each once; nobody reads that of surfaces, whose
	                        materials are listed in place of them */
	uint32_t *slot;      /* [capacity] where in changed an id stands, if it does: changed[slot[id]] is id then */
	uint32_t changed_count;
} edit_ids;

typedef struct edit_model {
	float radius;        /* of its bounds, also while it is hidden; NaN: it was removed, or its node is too far away */
	uint32_t next;       /* as edit_ids.next */
	uint32_t slot;       /* as edit_ids.slot, in scene->moved */
	uint32_t figure;     /* 1 + the figure whose model it is (scene_play.h); 0: none's */
	bool hidden;         /* by the program */
	stilb_sphere sphere; /* around the spheres of its meshes, in the space of parts that have one transform */
	uint64_t measured;   /* stilb_scene_edits.measures when `sphere` was made; 0: never, or for other parts */
	uint32_t next_on_node, previous_on_node; /* 1 + a model that hangs on the same node; 0: there is none */
} edit_model;

/* The hierarchy, besides what stilb_scene_nodes has. Subtrees are ranges of `order`. */
typedef struct edit_nodes {
	uint32_t capacity;     /* of the scene's arrays of nodes, and of those below */
	uint32_t first_free;   /* as of edit_ids */
	uint32_t *next;        /* as edit_ids.next */
	uint32_t *children;    /* how many nodes hang on it */
	uint32_t *first_model; /* 1 + the first model that hangs on it; 0: none does */
	uint32_t *order;       /* [order_count] nodes, a parent before its children; STILB_SCENE_NONE: one was removed */
	uint32_t *end;         /* [order_count] where in order the subtree ends that begins here */
	uint32_t *position;    /* where a node stands in order */
	uint32_t *figure;      /* 1 + the figure whose node it is (scene_play.h); 0: none's */
	uint32_t order_count, hole_count;
	bool unordered;        /* order, end and position are to be made anew */
	uint32_t *first_child; /* while they are made: 1 + a node */
	uint32_t *sibling;     /* the same */
	uint32_t *changed;     /* [changed_count] nodes with other places than at the last update, each once */
	uint32_t *slot;        /* as edit_ids.slot */
	unsigned char *marks;  /* [order_count] 1 during an update: the node there has changed */
	uint32_t changed_count;
} edit_nodes;

typedef struct stilb_scene_edits {
	edit_ids meshes, materials, surfaces, textures, functions;
	edit_nodes nodes;
	stilb_sphere *mesh_sphere; /* [meshes.capacity] around a mesh's vertices; radius NaN: not computed yet */
	bool unmeasured;           /* a mesh in use may have no sphere yet */
	uint64_t measures;         /* 1 + the changes of meshes so far: spheres of models made before them may be wrong */
	uint32_t *mesh_figure;     /* [meshes.capacity] 1 + the figure whose posed mesh it is; 0: none's */
	uint64_t *mesh_pose;       /* [meshes.capacity] revisions.poses after it got its last one; 0: it had none */
	bool *mesh_stale;          /* [meshes.capacity] models that show it have the bounds of the mesh before */
	uint32_t stale_count;      /* meshes of which that is true */

	uint32_t model_capacity, part_capacity;
	edit_model *models;                 /* [model_capacity] */
	uint32_t free_models[EDIT_BUCKETS]; /* 1 + the first free model of each list; 0: none */

	stilb_scene_vertices *ranges; /* [range_count] */
	uint32_t range_count, range_capacity;
} stilb_scene_edits;

/* Makes the state if the scene has none yet. STILB_ERROR_MEMORY. */
stilb_result scene_edit_begin(stilb_scene *scene);

/* Frees scene->edits. Accepts NULL. */
void scene_edit_finish(stilb_scene_edits *edits);

/* Moves arrays with room for *capacity elements, of which `count` are in use, to memory for at least `needed`, the new
 * elements zeros. False: no memory; nothing has changed. */
bool scene_edit_grow(const edit_array *arrays, uint32_t array_count, uint32_t count, uint32_t needed,
                     uint32_t *capacity);

/* Lists a model in scene->moved unless it is there already. */
static inline void scene_edit_moved(stilb_scene *scene, uint32_t model)
{
	stilb_scene_edits *edits = scene->edits;
	STILB_ASSERT(edits && model < scene->model_count);
	uint32_t slot = edits->models[model].slot;
	if (slot < scene->moved_count && scene->moved[slot] == model)
		return;
	STILB_ASSERT(scene->moved_count < edits->model_capacity && "each model stands there once");
	edits->models[model].slot = scene->moved_count;
	scene->moved[scene->moved_count++] = model;
}

/* Lists an id among the changed ones of its kind, unless it is there already. */
void scene_edit_changed(edit_ids *ids, uint32_t id);

/* True if there is something with this id. count: ids given so far. */
bool scene_edit_has(const edit_ids *ids, uint32_t count, uint32_t id);

/* Gives all meshes in use their spheres, so that bounds can be made on several threads. */
void scene_edit_measure(stilb_scene *scene);

/* Puts all parts of a model at a transform, with its bounds; a model that would lie too far away gets NaN as their
 * radius and keeps the transforms that it had. Does not list it. Needs scene_edit_measure.
 * [any-thread], for each model one at a time */
void scene_edit_place_model(stilb_scene *scene, uint32_t model, const stilb_mat4 *transform);

/* Takes a model off its node, if it hangs on one. */
void scene_edit_detach(stilb_scene *scene, uint32_t model);

/* Lists a node among those that the next update places. */
void scene_edit_node_changed(edit_nodes *nodes, uint32_t node);

/* The new bounds of models that show a mesh whose vertices have changed. */
void scene_edit_settle(stilb_scene *scene);

/* Gives the nodes that have changed, and all that hangs on them, their new places: stilb_scene_update_nodes without
 * posed meshes. Needs edits. */
void scene_edit_update_places(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker);

/* All vertices of a mesh without coarser levels have changed, tangents too, and lie in this box. Its models are to be
 * fitted anew by scene_edit_refit; those of which the caller does not know are when changes are read. */
void scene_edit_mesh_posed(stilb_scene *scene, uint32_t mesh, const float low[3], const float high[3],
                           uint32_t model_count);

/* Gives a model bounds for the meshes that it shows now, and lists it. */
void scene_edit_refit(stilb_scene *scene, uint32_t model);

#endif
