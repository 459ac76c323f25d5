/* The figures of a scene: what they share, what each plays, and what it deforms. Inside scene/. */
#ifndef STILB_SCENE_PLAY_INTERNAL_H
#define STILB_SCENE_PLAY_INTERNAL_H

#include "scene/edit/scene_edit_internal.h"
#include "scene/play/scene_play.h"
#include "scene/play/scene_play_skin.h"

/* ---- shared by all figures --------------------------------------------------------------------------------------- */

/* Key times that channels of a clip share: where a time stands among them is found once. */
typedef struct play_track {
	uint32_t first_time, key_count; /* in animation->times */
	float rate;                     /* keys a second, if they were evenly spaced: where to look first */
} play_track;

/* What the channels of all clips replace, each once. */
typedef struct play_target {
	uint32_t node; /* of the animation */
	stilb_scene_path path;
	uint32_t width, first; /* its numbers in a row of values, which has room for them to the next four */
} play_target;

/* What a channel reads and writes. */
typedef struct play_channel {
	uint32_t track, target;
} play_channel;

/* A clip, made ready. */
typedef struct play_clip {
	uint32_t first_track, track_count; /* in play_shared.tracks */
	uint32_t rotation_count;           /* of its channels, the first of `order` that turn by LINEAR */
} play_clip;

/* What a mesh is at rest, and what carries its vertices. Streams hold a number of each vertex, and arrays have room for
 * vertices to the next eight. */
typedef struct play_rest {
	float *streams; /* [PLAY_STREAMS][stride], or [PLAY_STREAMS_PLAIN][stride] of a mesh without extras */
	/* What carries it: play_skin has the same. NULL: no skin does. */
	uint32_t *starts;
	uint16_t *joints;
	float *weights;
	bool tangents; /* the mesh has extras */
	uint32_t vertex_count, stride;
} play_rest;

/* Streams of a mesh at rest: numbers of positions, normals and uv, then of tangents. */
enum { PLAY_POSITION = 0, PLAY_NORMAL = 3, PLAY_UV = 6, PLAY_STREAMS_PLAIN = 8, PLAY_TANGENT = 8, PLAY_STREAMS = 12 };

static inline const float *play_stream(const play_rest *rest, uint32_t stream, uint32_t first)
{
	return rest->streams + (size_t)stream * rest->stride + first;
}

/* A mesh of every figure whose vertices follow a pose: that of one part of the models that a node shows. */
typedef struct play_posed {
	uint32_t node;   /* of the animation */
	uint32_t part;   /* of its models, counted from 0 within each */
	uint32_t deform; /* in animation->deforms, and in play_shared.rests */
	uint32_t skin;   /* or STILB_SCENE_NONE */
} play_posed;

typedef struct play_shared {
	uint32_t target_count, track_count, posed_count, value_count;
	play_target *targets;   /* [target_count] by ascending node */
	play_channel *channels; /* [animation->channel_count] */
	uint32_t *order;        /* [animation->channel_count] for each clip its channels, in the order of their work */
	play_clip *clips;       /* [animation->clip_count] */
	play_track *tracks;     /* [track_count] */
	play_rest *rests;       /* [animation->deform_count] {0}: no node shows it deformed */
	play_posed *posed;      /* [posed_count] by ascending node */
	/* For rates, made when they are set: how far from it what hangs on a node lies at rest, metres,
	 * [animation->node_count], and a sphere about the place's origin around a figure at rest. */
	float *reach, radius;
	uint32_t first_model, model_count; /* of figure 0, all that nodes show; others have as many */
	uint32_t most_tracks;              /* of a clip */
	uint32_t *moved; /* [moved_count] nodes of the animation that clips can move; first those that hang on no other */
	uint32_t moved_count, top_count;
	uint32_t *carriers; /* [carrier_count] nodes that are joints, or above joints, ascending */
	uint32_t carrier_count;
} play_shared;

/* ---- figures ----------------------------------------------------------------------------------------------------- */

/* A posed mesh of a figure. */
typedef struct play_mesh {
	uint32_t mesh; /* STILB_SCENE_NONE: it is the program's now */
	bool stale;    /* its weights or joints have changed */
} play_mesh;

/* Where a time stands among the keys of a track. */
typedef struct play_cursor {
	uint32_t key, next; /* the same on a key before or after which there is none */
	float share;        /* [0, 1) of the way from one to the other */
	float span;         /* seconds between them */
} play_cursor;

typedef struct play_figure {
	uint32_t next;           /* 1 + the next free one, EDIT_IN_USE: it is none */
	uint32_t place;          /* the node on which all of it stands; STILB_SCENE_NONE: the world */
	uint32_t *nodes;         /* [animation->node_count] of the scene; STILB_SCENE_NONE: removed */
	uint32_t *models;        /* [shared->model_count] of the scene; STILB_SCENE_NONE: removed */
	play_mesh *meshes;       /* [shared->posed_count] */
	stilb_mat4 *places;      /* [animation->node_count] of carriers, to the figure's place; unused without one */
	play_rows *joints;       /* [animation->joint_count] from the mesh at rest to the figure's place */
	float *weights;          /* [animation->weight_count] of morph targets */
	float *shown_weights;    /* the same, of the pose that its meshes have */
	bool *turned;            /* [animation->skin_count] while it is posed: a joint of the skin has changed */
	stilb_scene_play *plays; /* [play_count] */
	uint32_t play_count;
	bool behind;             /* its times have moved since it was posed */
	float least;             /* metres: nodes that reach less far keep their poses */
	uint32_t sampled, still; /* channels in the last call */
	bool fresh;              /* its plays are to be shown even if their times stand still */
	bool posing;             /* its weights may have changed since its meshes were posed */
	bool whole;              /* all that clips move hangs where the file has it */
} play_figure;

/* What a thread needs to sample a figure. */
typedef struct play_scratch {
	float *row;           /* [value_count + target_count] sums of the targets' values, and of their weights */
	play_cursor *cursors; /* [most_tracks] */
} play_scratch;

/* A mesh to pose. Meshes are posed in chunks, each a job's. */
typedef struct play_work {
	uint32_t figure, posed, first_chunk;
} play_work;

#define PLAY_CHUNK 1024u /* vertices */

typedef struct play_box {
	float low[3], high[3];
} play_box;

typedef struct play_end {
	uint32_t figure, play;
	void (*ended)(void *user, uint32_t figure, uint32_t play);
	void *user;
} play_end;

typedef struct stilb_scene_figures {
	play_shared shared;
	play_figure *figures; /* [count], room for capacity */
	uint32_t count, capacity, first_free;
	uint32_t in_use;
	stilb_scene_rates rates;
	uint32_t calls; /* of stilb_scene_advance */
	stilb_scene_play_counts counts;
	/* While figures are sampled or posed; there is room for all of them. */
	uint32_t *due;   /* the figures that it concerns */
	play_work *work; /* [work_count] their meshes */
	play_box *boxes; /* of chunks of vertices */
	uint32_t work_count;
	play_scratch *scratch; /* [scratch_count] of threads, by their index; one at least */
	uint32_t scratch_count;
	play_skin_fn *skin; /* of this CPU */
	uint32_t swept_count;
	play_box swept[STILB_SCENE_SWEEP]; /* [swept_count] around all models, at times of a clip */
	play_end *ends;                    /* [end_count] plays that have come to their ends */
	uint32_t end_count, end_capacity;
} stilb_scene_figures;

static inline uint32_t play_chunks(const play_rest *rest)
{
	return rest->vertex_count / PLAY_CHUNK + (rest->vertex_count % PLAY_CHUNK > 0);
}

/* scene_play_shared.c: what clips and meshes need. STILB_ERROR_MEMORY; scene_play_finish frees what was made. */
stilb_result scene_play_share(const stilb_scene *scene, play_shared *shared);

/* scene_play_rates.c: the figure is to be sampled in this call; if not, it waits. */
bool scene_play_is_due(const stilb_scene *scene, uint32_t figure);

/* scene_play_sample.c: gives the figures of due[0 .. count - 1] the poses of their plays, and lists their nodes as
 * changed. */
void scene_play_sample(stilb_scene *scene, uint32_t count, stilb_job_pool *pool, uint32_t worker);

/* The same file: scratch for so many threads. False: no memory; there is as much as before. */
bool scene_play_reserve_scratch(stilb_scene_figures *all, uint32_t threads);

/* scene_play_pose.c: gives posed meshes whose joints or weights have changed their vertices, and their models bounds.
 * Nodes have their places. */
void scene_play_pose(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker);

/* scene_play.c: figure 0 of a scene that was just opened, in its pose at rest; nothing if nothing of it moves.
 * STILB_ERROR_MEMORY; the scene is to be destroyed then. */
stilb_result scene_play_begin(stilb_scene *scene);

/* True if a node shows a mesh that a skin carries. */
bool scene_play_is_skinned(const stilb_scene *scene, uint32_t node);

/* scene_play_figures.c: frees what a figure has, and all figures of a scene, which may have none. */
void scene_play_free_figure(play_figure *figure);
void scene_play_finish(stilb_scene *scene);

/* The same file: the figure to which a node, a model or a posed mesh belongs has it no longer. figure: 1 + its
 * index. */
void scene_play_forget_node(stilb_scene *scene, uint32_t figure, uint32_t node);
void scene_play_forget_model(stilb_scene *scene, uint32_t figure, uint32_t model);
void scene_play_forget_mesh(stilb_scene *scene, uint32_t figure, uint32_t mesh);

#endif
