/* The built-in scenes, which STILB_SCENE_BUILTINS describes. number: the one in the scene's name, 0 if its name has
 * none. STILB_ERROR_MEMORY; *scene is NULL then. */
#ifndef STILB_SCENE_BUILTIN_H
#define STILB_SCENE_BUILTIN_H

#include "scene/scene.h"

stilb_result scene_create_cornell(float number, stilb_scene **scene);
stilb_result scene_create_outdoor(float number, stilb_scene **scene);
stilb_result scene_create_furnace(float reflectance, stilb_scene **scene);
stilb_result scene_create_plane_wall(float number, stilb_scene **scene);
stilb_result scene_create_stress_default(float number, stilb_scene **scene);
stilb_result scene_create_spheres(float number, stilb_scene **scene);

#endif
