/* demo_picture: names for the pictures that F12 saves. */
#ifndef STILB_DEMO_PICTURE_H
#define STILB_DEMO_PICTURE_H

/* Returns path if no file has that name yet, else path with "-2", "-3", ... before its extension, as captures are
 * numbered: no picture replaces an older one. last, or NULL, is the name of the picture that the run saves at its end,
 * which is not returned either. The caller frees the result; NULL: out of memory. [any-thread] */
char *demo_picture_name(const char *path, const char *last);

#endif
