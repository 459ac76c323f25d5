/*
 * scene_lights: SCENE.lights.json, which stands beside a scene's file and says what a user has changed of its lights.
 *
 *   {
 *     "lights": [
 *       {"light": 0, "kind": "spot", "unit": "cd", "intensity": 250, "color": [1, 0.6, 0.3], "place": [0, 2.5, 1]},
 *       {"light": 3, "temperature": 2700}
 *     ]
 *   }
 *
 * light        index in the scene's list; each at most once
 * kind, unit   may be left out; if they are there and the light's are others, the file is of another scene: an error
 * intensity    >= 0, of the brightest channel: candela ("cd"), of DIRECTIONAL lux ("lx"); of radiometric lights
 *              W sr^-1 ("W/sr") and W m^-2 ("W/m2")
 * color        linear Rec.709, >= 0, not all 0; only its hue counts. temperature: kelvin, 1000 .. 15000, in place of it
 * place        metres, in the world, or in the space of the node on which the light hangs; not of DIRECTIONAL
 * What is left out of a light stays as the scene's file has it, and so does all else.
 *
 * Life cycle.  stilb_scene_open reads the file; a window changes lights; stilb_scene_lights_save writes what differs
 *              from the scene's own file.
 * Limits.      A light with a face keeps colour and intensity, which are those of the face's material. Built-in scenes
 *              have no such file.
 * Threads.     [one-writer], as edits (scene_edit.h).
 */
#ifndef STILB_SCENE_LIGHTS_H
#define STILB_SCENE_LIGHTS_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_SCENE_LIGHTS_SUFFIX ".lights.json"

/* Writes what the lights have that the scene's file has not. *path: of the written file, the scene's own string; NULL:
 * nobody asks. STILB_ERROR_ARGUMENT: the scene is of no file, or its list of lights is not the file's any more.
 * STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result stilb_scene_lights_save(const stilb_scene *scene, const char **path);

/* True if the file is another one than the scene read when it was opened, or wrote since, or has come or gone. Of a
 * scene of no file false. */
bool stilb_scene_lights_changed(const stilb_scene *scene);

/* Gives a light the colour, the place and the intensity of the scene's file. Of a scene of no file nothing changes. */
void stilb_scene_lights_restore(stilb_scene *scene, uint32_t light);

/* Moves a light to a position in the world; one that hangs on a node keeps that place on it. False: the light would be
 * out of its ranges, or is DIRECTIONAL, or its node is flat; it stays where it is. */
bool stilb_scene_move_light(stilb_scene *scene, uint32_t light, const float position[3]);

/* "point", "spot", ...; NULL-terminated. The index is the stilb_scene_light_kind. */
extern const char *const stilb_scene_light_kind_names[];

/* "cd", "lx", "W/sr" or "W/m2". */
const char *stilb_scene_light_unit_name(const stilb_scene_light *light);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
