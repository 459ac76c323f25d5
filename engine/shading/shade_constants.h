/* shade_constants: numbers that several shading headers need. */
#ifndef SHADE_CONSTANTS_H
#define SHADE_CONSTANTS_H

#define SHADE_PI 3.14159265358979323846f
#define SHADE_INV_PI 0.31830988618379067154f

#endif
