/* A reader for the part of TOML that scenes use: tables, arrays of tables, one key on a line. */
#ifndef SCENE_H
#define SCENE_H

/* The whole file, with a zero behind it; NULL, with errno, if it cannot be read. */
char *read_file(const char *path, size_t *length);
/* Calls take("table.key", value) for each key, and take("table", NULL) where [[table]] begins a new one. Strings keep
 * their quotes. */
void read_scene(char *text, void (*take)(const char *key, const char *value));

#endif
