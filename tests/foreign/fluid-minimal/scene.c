#define _DEFAULT_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

char *read_file(const char *path, size_t *length)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    char *text = NULL;
    size_t room = 0;
    *length = 0;
    do {
        room = 2 * room + 4096;
        char *more = realloc(text, room + 1);
        if (!more)
            break;
        text = more;
        *length += fread(text + *length, 1, room - *length, file);
    } while (*length == room);
    if (ferror(file) || *length == room) {
        free(text);
        text = NULL;
    } else {
        text[*length] = 0;
    }
    fclose(file);
    return text;
}

/* Ends a line at its comment; returns how many brackets it opens less those it closes. */
static int trim(char *line)
{
    int open = 0;
    for (char quote = 0; *line; line++) {
        if (quote) {
            quote = *line == quote ? 0 : quote;
        } else if (*line == '"' || *line == '\'') {
            quote = *line;
        } else if (*line == '#') {
            *line = 0;
            break;
        } else {
            open += (*line == '[' || *line == '{') - (*line == ']' || *line == '}');
        }
    }
    return open;
}

void read_scene(char *text, void (*take)(const char *key, const char *value))
{
    char table[200] = "", name[200], key[440], value[4096], *rest = text, *line;
    while ((line = strsep(&rest, "\n"))) {
        int open = trim(line);
        line += strspn(line, " \t");
        char *equals = strchr(line, '=');
        if (sscanf(line, "[[%199[^]]", table) == 1) {
            take(table, NULL);
        } else if (*line == '[') {
            sscanf(line, "[%199[^]]", table);
        } else if (equals && sscanf(line, "%199[^= \t]", name) == 1) {
            snprintf(value, sizeof value, "%s", equals + 1 + strspn(equals + 1, " \t"));
            while (open > 0 && (line = strsep(&rest, "\n"))) {
                open += trim(line);
                strncat(value, line, sizeof value - strlen(value) - 1);
            }
            snprintf(key, sizeof key, "%s%s%s", table, *table ? "." : "", name);
            take(key, value);
        }
    }
}
