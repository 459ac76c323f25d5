/* Names of the pictures that F12 takes. */
#ifndef STILB_DEMO_PICTURE_H
#define STILB_DEMO_PICTURE_H

/* path if there is nothing of that name yet, else with "-2" before its ending, "-3", and so on, as captures are
 * numbered: no picture is replaced. last is left out, too: the picture that the end of the run writes; NULL: it writes
 * none. The caller frees the name; NULL: no memory. */
char *demo_picture_name(const char *path, const char *last);

#endif
