/* The built-in scenes; what each shows is said at stilb_scene_open. number: of the name, where it takes one. */
#ifndef STILB_SCENE_BUILTIN_H
#define STILB_SCENE_BUILTIN_H

#include "scene/scene.h"

stilb_result scene_create_cornell(float number, stilb_scene **scene);
stilb_result scene_create_outdoor(float number, stilb_scene **scene);
stilb_result scene_create_furnace(float reflectance, stilb_scene **scene);
stilb_result scene_create_plane_wall(float number, stilb_scene **scene);
stilb_result scene_create_field(float number, stilb_scene **scene);
stilb_result scene_create_spheres(float number, stilb_scene **scene);

#endif
