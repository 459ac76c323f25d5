/*
 * picture_flags: the flags about the picture, each once for all commands that have it: a command adds the groups that
 * it wants to its table. Help and manual pages come from the same rows.
 *
 *   picture_flags picture = picture_flags_default();
 *   flag_rows table = {0};
 *   picture_flags_add(&picture, PICTURE_DEVICE, &table);
 *   picture_flags_add(&picture, PICTURE_BRDF, &table);
 *   if (flags_parse(table.rows, table.count, argc, argv) == FLAGS_OK && picture_flags_check(&picture))
 *       desc.shading = picture_flags_shading(&picture, SHADE_BRDF_MICROFACET);
 *
 * Threads.  [any-thread] for flags that nobody changes.
 */
#ifndef STILB_PICTURE_FLAGS_H
#define STILB_PICTURE_FLAGS_H

#include "engine.h"
#include "game/cli/flags.h"

#define PICTURE_NOT_GIVEN (-1)

typedef enum picture_studio {
	PICTURE_STUDIO_AUTO, /* for scenes of files without any light */
	PICTURE_STUDIO_ON,
	PICTURE_STUDIO_OFF,
} picture_studio;

typedef struct picture_flags {
	int device, replay, materials;     /* a stilb_render_device_kind, _replay_mode and _materials */
	int specular_aa;                   /* a stilb_render_specular_aa */
	int lighting, coverage, gbuffer;   /* a stilb_render_lighting, _coverage and _gbuffer */
	int light_lists;                   /* a stilb_render_light_lists */
	float light_tolerance, light_fade; /* a share of display white; pixels */
	int ambient;                       /* a stilb_render_ambient */
	int shadows;                       /* a stilb_engine_shadow_kind */
	int shadow_faces;                  /* a stilb_engine_shadow_faces */
	int shadow_bias, shadow_filter;    /* a stilb_engine_shadow_bias, _filter */
	uint64_t cascades, cascade_size;   /* 0 if not given */
	uint64_t shadow_samples;
	bool shadow_objects;
	float shadow_distance;               /* metres */
	uint64_t samples;                    /* 0 if not given */
	uint64_t max_anisotropy;             /* 0 if not given */
	float occlusion, occlusion_radius;   /* of stilb_post_settings */
	int dither;                          /* a stilb_post_dither */
	int hdr;                             /* a stilb_render_hdr */
	const char *grade, *preset;          /* NULL if not given */
	stilb_post_settings post;            /* those of the preset, for what has no flag */
	int aa;                              /* a stilb_post_aa */
	float bloom, bloom_width;            /* likewise */
	float motion_blur, motion_blur_most; /* likewise */
	float motion_blur_far;               /* likewise */
	int motion;                          /* a stilb_post_motion */
	int bloom_format, post_place;        /* a stilb_post_bloom_format, a stilb_post_place */
	int reflections;                     /* a stilb_post_reflections */
	int dof;                             /* a stilb_post_dof */
	float aperture, focus;               /* of stilb_post_settings */
	uint64_t blades;
	int brdf, ndf, g, f;                         /* a SHADE_BRDF_, _NDF_, _G_ and _F_, or PICTURE_NOT_GIVEN */
	float roughness, anisotropy, wrap, specular; /* added to each material's value; NaN: the chosen BRDF's default */
	bool validate, allow_outside, quiet;
	const char *gpu, *environment, *camera, *exposure, *variant, *background, *animation; /* NULL if not given */
	float at;                      /* seconds in the clip of --animation */
	int studio;                    /* a picture_studio */
	int tone;                      /* a SHADE_TONE_..., or PICTURE_NOT_GIVEN: the scene's */
	int detail;                    /* stilb_render_detail_mode */
	const char *show, *show_range; /* NULL if not given */
	float detail_error;            /* pixels */
} picture_flags;

typedef enum picture_flags_group {
	PICTURE_COMMANDS, /* --replay, --materials: how frames are drawn; the same pixels each way */
	PICTURE_DEVICE,   /* --device, --gpu, --validate */
	PICTURE_SAMPLES,  /* --msaa, --max-anisotropy, --specular-aa */
	PICTURE_LIGHTING, /* --lighting, --light-..., --gbuffer: how pixels find lights, which are left out; --ambient */
	PICTURE_DETAIL,   /* --lod, --lod-error, --show, --show-range: what frames show, and how finely */
	PICTURE_IMAGE,    /* --show and --show-range for images of the plan alone */
	PICTURE_POSE,     /* --animation, --at: what of a file's scene plays */
	PICTURE_PLACE,    /* --camera, --environment, --variant, --allow-outside, --quiet: a file's scene, and its camera */
	PICTURE_LOOK,     /* --studio, --background: how the picture shows the scene */
	PICTURE_EXPOSURE, /* --exposure */
	PICTURE_TONE,     /* --tone */
	PICTURE_POST,     /* --bloom...: effects on the light of frames */
	PICTURE_BRDF,     /* --brdf and the parts of --brdf microfacet */
	PICTURE_ADDED,    /* what is added to the materials: frames alone have it */
} picture_flags_group;

/* The words that --replay, --materials, --specular-aa and --device accept, in the order of the engine's enumerations;
 * NULL-terminated. */
extern const char *const picture_replay_choices[];
extern const char *const picture_materials_choices[];
extern const char *const picture_specular_aa_choices[];
extern const char *const picture_device_choices[];

picture_flags picture_flags_default(void);

/* The image of the plan that --show names. */
typedef struct picture_shown {
	char name[64];
	uint32_t mip, layer;
	float low, high;
} picture_shown;

/* What --show says of a checked p: a kind, or true and an image. */
bool picture_flags_show(const picture_flags *p, stilb_render_show *show, picture_shown *image);

/* Appends the rows of a group; their values are those of *picture. */
void picture_flags_add(picture_flags *picture, picture_flags_group group, flag_rows *table);

/* Checks what the table cannot express. Returns false after one line on stderr. */
bool picture_flags_check(const picture_flags *picture);

/* Of these what a preset may say, too: effects that do not go with other flags. */
bool picture_flags_check_look(const picture_flags *picture);

/* Prints the error of a run that did not start; if that is the device's, with the flag that does without it. */
void picture_flags_log_start(const picture_flags *picture, stilb_result result);

/* The levels of detail of frames. */
stilb_render_detail picture_flags_detail(const picture_flags *picture);

/* True if a part of the microfacet model is chosen, which implies it: its D, G or F. */
bool picture_flags_parts(const picture_flags *picture);

/* The shading of frames. brdf: the SHADE_BRDF_ without --brdf and its parts. */
stilb_render_shading picture_flags_shading(const picture_flags *picture, uint32_t brdf);

/* Sets the camera of --camera, numbers or one of the file's, in place of the scene's, for a picture of this aspect:
 * width / height. A scene whose file has no camera is framed for it. STILB_ERROR_ARGUMENT: the file has no such
 * camera. */
stilb_result picture_flags_place(const picture_flags *picture, float aspect, stilb_scene *scene);

/* The camera of the file that the text of a flag names, by its number from 1 on or its name. STILB_ERROR_ARGUMENT:
 * there is none; the message lists those that there are. */
stilb_result picture_flags_camera(const char *name, const char *text, const stilb_scene *scene, uint32_t *index);

/* The camera that a text like --camera's stands for: one of the file's, or the scene's in another place. Errors as
 * picture_flags_camera. */
stilb_result picture_flags_look(const char *name, const char *text, const stilb_scene *scene,
                                stilb_scene_camera *camera);
/* False, after a line, if the text is meant as numbers and they are wrong. NULL is right. */
bool picture_flags_check_camera(const char *name, const char *text);

/* Sets the exposure of the scene's camera to that of --exposure; call after picture_flags_place. Without the flag it is
 * 0, and metered (stilb_scene_meter) if the scene has photometric lights, as glTF's, or lights that would show a white
 * surface as more than 8: exporters write watts. The meter looks from this camera; if the scene is framed, from where a
 * square picture is, so that the exposure is the same for every shape of the picture. *metered: it was. Also sets a
 * colour of --background, which is shown as it is, whatever the exposure, and the tone map of --tone.
 * STILB_ERROR_MEMORY. */
stilb_result picture_flags_expose(const picture_flags *picture, stilb_scene *scene, bool *metered);

/* True if --exposure says that frames adapt to the light; the scene's camera then has 0. */
bool picture_flags_adapt(const picture_flags *picture);

/* The settings of effects on the light of frames. */
stilb_post_settings picture_flags_post(const picture_flags *picture);

/* Sets the tone map of the scene's cameras to that of --tone, if it is given; picture_flags_expose does so, too. */
void picture_flags_tone(const picture_flags *picture, stilb_scene *scene);

/* Plays the clip of --animation, or else the first one, from the time of --at on: the scene has its pose then. Call it
 * before what depends on where things are. STILB_ERROR_ARGUMENT: the scene has no such clip; the message lists those
 * that there are. STILB_ERROR_MEMORY. */
stilb_result picture_flags_pose(const picture_flags *picture, stilb_scene *scene);

/* Shows the variant of --variant. STILB_ERROR_ARGUMENT: the scene has none of this name; STILB_ERROR_MEMORY. */
stilb_result picture_flags_variant(const picture_flags *picture, stilb_scene *scene);

/* Lights a scene that was opened with stilb_scene_open_options.dark: replaces its surroundings by the colour or the
 * panorama of --environment, or else puts it into the studio of --studio, which is placed for the camera of the flags;
 * and sets what --background shows, but a colour. A line says that a file has no light. name: what the scene was opened
 * by. STILB_ERROR_ARGUMENT, STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result picture_flags_surroundings(const picture_flags *picture, const char *name, stilb_scene *scene);

/* True if files with alpha are to be transparent where no model is. */
bool picture_flags_are_transparent(const picture_flags *picture);

#endif
