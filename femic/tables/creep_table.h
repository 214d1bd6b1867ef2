/* Read a table of creep forces that femic wrote (table.txt), and interpolate in it. C99, one header.

       creep_table *table = creep_table_read("table.txt");
       double forces[CREEP_FORCES];
       int failed = creep_table_forces(table, shift, load, friction, longitudinal, lateral, spin, forces);
       creep_table_free(table);

   Units are mm, N, MPa, rad. x points along the track, z up from the rail into the wheel. The approach of the
   bodies is that under the load without friction; it stays when friction acts. Creepages are those of the
   wheel: longitudinal is omega R / V - 1, lateral the lateral velocity over V, spin [1/mm] the angular
   velocity about z over V. Cubic interpolation with continuous slopes, over the logarithm of the load, as in
   creep_table.py. Numbers are read with a decimal point: LC_NUMERIC has to be that of C. */

#ifndef CREEP_TABLE_H
#define CREEP_TABLE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CREEP_SHIFT, CREEP_LOAD, CREEP_FRICTION, CREEP_SPIN, CREEP_ANGLE, CREEP_CREEPAGE, CREEP_AXES };
enum { CREEP_NORMAL_FORCE, CREEP_CONTACT_ANGLE, CREEP_CREEPAGE_SCALE, CREEP_HALF_SIZE, CREEP_FREE_CREEPAGE,
       CREEP_CONTACT_P_MAX, CREEP_APPROACH, CREEP_CONTACT_Y, CREEP_CONTACT_Z, CREEP_CONTACT };
enum { CREEP_F_X, CREEP_F_Y, CREEP_F_Z, CREEP_M_N, CREEP_P_MAX, CREEP_WORK, CREEP_FORCES };
/* [N], [N], [N], [N mm], [MPa], [N] */

typedef struct {
    int count[CREEP_AXES];
    double *nodes[CREEP_AXES];
    int is_log[CREEP_CONTACT];
    double *contact[CREEP_CONTACT]; /* over shift, load */
    double *force[CREEP_FORCES];    /* over all axes, the last one fastest: f_x, f_y, f_n, m_n, p, w */
} creep_table;

static int creep_word(FILE *file, char *word) { /* the next word, without comments; 0 at the end */
    int c, length = 0;
    while ((c = getc(file)) != EOF) {
        if (c == '#') { while (c != '\n' && c != EOF) c = getc(file); }
        if (c == EOF || c == ' ' || c == '\n' || c == '\r' || c == '\t') { if (length) break; else continue; }
        if (length < 63) word[length++] = (char)c;
    }
    word[length] = 0;
    return length;
}

static int creep_is(FILE *file, const char *expected) {
    char word[64];
    return creep_word(file, word) && !strcmp(word, expected);
}

static int creep_int(FILE *file) {
    char word[64];
    return creep_word(file, word) ? atoi(word) : -1;
}

static double *creep_numbers(FILE *file, long count) {
    char word[64], *end;
    double *values = count > 0 ? malloc((size_t)count * sizeof *values) : NULL;
    for (long k = 0; values && k < count; k++) {
        int some = creep_word(file, word);
        values[k] = strtod(word, &end);
        if (!some || *end) { free(values); values = NULL; }
    }
    return values;
}

static void creep_table_free(creep_table *table) {
    if (!table) return;
    for (int k = 0; k < CREEP_AXES; k++) free(table->nodes[k]);
    for (int k = 0; k < CREEP_CONTACT; k++) free(table->contact[k]);
    for (int k = 0; k < CREEP_FORCES; k++) free(table->force[k]);
    free(table);
}

/* Return the table in a file, or NULL. */
static creep_table *creep_table_read(const char *path) {
    static const char *axes[] = {"shift", "load", "friction", "spin", "angle", "creepage"};
    static const char *contact[] = {"normal_force", "contact_angle", "creepage_scale", "half_size", "free_creepage",
                                    "p_max", "approach", "y", "z"};
    static const char *force[] = {"f_x", "f_y", "f_n", "m_n", "p", "w"};
    char word[64];
    FILE *file = fopen(path, "r");
    creep_table *table = calloc(1, sizeof *table);
    int good = file && table && creep_is(file, "femic-creep-table") && creep_int(file) == 1;
    long size = 1;
    for (int k = 0; good && k < CREEP_AXES; k++) {
        good = creep_is(file, axes[k]) && (table->count[k] = creep_int(file)) > 0
               && (table->nodes[k] = creep_numbers(file, table->count[k])) != NULL;
        for (int i = 0; good && k == CREEP_LOAD && i < table->count[k]; i++)
            table->nodes[k][i] = log(table->nodes[k][i]);
        size *= table->count[k];
    }
    good = good && creep_int(file) == CREEP_CONTACT;
    for (int k = 0; good && k < CREEP_CONTACT; k++) {
        good = creep_is(file, contact[k]) && creep_word(file, word);
        table->is_log[k] = good && !strcmp(word, "log");
        good = good && (table->contact[k] = creep_numbers(file, (long)table->count[0] * table->count[1]));
    }
    good = good && creep_int(file) == CREEP_FORCES;
    for (int k = 0; good && k < CREEP_FORCES; k++)
        good = creep_is(file, force[k]) && (table->force[k] = creep_numbers(file, size)) != NULL;
    good = good && creep_is(file, "end");
    if (file) fclose(file);
    if (!good) { creep_table_free(table); table = NULL; }
    return table;
}

static void creep_slope(const double *nodes, int first, int count, int at, double share, double *weights) {
    if (count == 2) {
        double slope = share / (nodes[1] - nodes[0]);
        weights[0] -= slope; weights[1] += slope;
        return;
    }
    for (int k = 0; k < 3; k++) {
        double p = nodes[first + k], q = nodes[first + (k + 1) % 3], r = nodes[first + (k + 2) % 3];
        weights[first + k] += share * (2 * nodes[at] - q - r) / ((p - q) * (p - r));
    }
}

/* Weights of up to four nodes; returns their number, and the first of them in *first. */
static int creep_stencil(const double *nodes, int count, double value, int *first, double weights[4]) {
    double all[4] = {0, 0, 0, 0}; /* of the nodes from `start` */
    int k = 0, start, n;
    *first = 0;
    weights[0] = 1;
    if (count == 1) return 1;
    while (k < count - 2 && nodes[k + 1] <= value) k++;
    start = k > 0 ? k - 1 : 0;
    n = (k + 2 < count ? k + 2 : count - 1) - start + 1;
    nodes += start;
    k -= start;
    double width = nodes[k + 1] - nodes[k], t = (value - nodes[k]) / width;
    all[k] += (1 + 2 * t) * (1 - t) * (1 - t);
    all[k + 1] += t * t * (3 - 2 * t);
    for (int j = 0; j < 2; j++) {
        int from = k + j - 1, three = n < 3 ? n : 3;
        if (from > n - three) from = n - three;
        if (from < 0) from = 0;
        double share = j ? -width * t * t * (1 - t) : width * t * (1 - t) * (1 - t);
        creep_slope(nodes, from, three, k + j, share, all);
    }
    memcpy(weights, all, sizeof all);
    *first = start;
    return n;
}

/* Weights along an axis; returns their number, 0 if the value is not in the table. Nodes of loads are logs. */
static int creep_along(const creep_table *table, int axis, double value, int *first, double weights[4]) {
    const double *nodes = table->nodes[axis];
    double low = nodes[0], high = nodes[table->count[axis] - 1];
    if (axis == CREEP_LOAD) value = log(value);
    double slack = 1e-9 * fmax(fabs(low), fabs(high));
    if (!(value >= low - slack && value <= high + slack)) return 0;
    return creep_stencil(nodes, table->count[axis], fmin(fmax(value, low), high), first, weights);
}

/* The contact without friction, by the names above. Returns 0, or 1 + the axis whose value is not there. */
static int creep_table_contact(const creep_table *table, double shift, double load, double *contact) {
    int i, j, n, m;
    double u[4], v[4];
    if (!(n = creep_along(table, CREEP_SHIFT, shift, &i, u))) return 1 + CREEP_SHIFT;
    if (!(m = creep_along(table, CREEP_LOAD, load, &j, v))) return 1 + CREEP_LOAD;
    for (int k = 0; k < CREEP_CONTACT; k++) {
        double sum = 0;
        for (int a = 0; a < n; a++)
            for (int b = 0; b < m; b++) {
                double value = table->contact[k][(i + a) * table->count[CREEP_LOAD] + j + b];
                sum += u[a] * v[b] * (table->is_log[k] ? log(value) : value);
            }
        contact[k] = table->is_log[k] ? exp(sum) : sum;
    }
    return 0;
}

/* Forces on the wheel, moment about the normal, largest pressure, work. Returns as creep_table_contact. */
static int creep_table_forces(const creep_table *table, double shift, double load, double friction,
                              double longitudinal, double lateral, double spin, double *forces) {
    double contact[CREEP_CONTACT], weights[4][4], ray[4], circle[4], value[CREEP_FORCES] = {0};
    int first[4], n[4], outward, failed = creep_table_contact(table, shift, load, contact);
    if (failed) return failed;
    double sine = sin(contact[CREEP_CONTACT_ANGLE]), cosine = cos(contact[CREEP_CONTACT_ANGLE]);
    double saturation = friction * contact[CREEP_CREEPAGE_SCALE];
    double along = (longitudinal - contact[CREEP_FREE_CREEPAGE] + spin * contact[CREEP_CONTACT_Y]) / saturation;
    double across = lateral * cosine / saturation, creepage = hypot(along, across);
    double at[4] = {shift, load, friction, spin * contact[CREEP_HALF_SIZE] / saturation};
    for (int k = 0; k < 4; k++)
        if (!(n[k] = creep_along(table, k, at[k], &first[k], weights[k]))) return 1 + k;
    int angles = table->count[CREEP_ANGLE], rays = table->count[CREEP_CREEPAGE];
    double turns = atan2(across, along) / (2 * acos(-1.0)) * angles, before = floor(turns);
    double around[4] = {before - 1, before, before + 1, before + 2};
    int unused, of_circle = creep_stencil(around, 4, turns, &unused, circle);
    double *extended = malloc((size_t)(rays + 1) * sizeof *extended); /* the ray of the opposite angle */
    if (!extended) return -1;
    extended[0] = -table->nodes[CREEP_CREEPAGE][1];
    memcpy(extended + 1, table->nodes[CREEP_CREEPAGE], (size_t)rays * sizeof *extended);
    int of_ray = creep_stencil(extended, rays + 1, creepage / (1 + creepage), &outward, ray);
    free(extended);
    for (int a = 0; a < n[0]; a++) for (int b = 0; b < n[1]; b++)
    for (int c = 0; c < n[2]; c++) for (int d = 0; d < n[3]; d++) {
        long row = ((long)(first[0] + a) * table->count[1] + first[1] + b) * table->count[2] + first[2] + c;
        row = row * table->count[3] + first[3] + d;
        double outer = weights[0][a] * weights[1][b] * weights[2][c] * weights[3][d];
        for (int e = 0; e < of_circle; e++) for (int f = 0; f < of_ray; f++) {
            int opposite = outward + f == 0, radius = opposite ? 1 : outward + f - 1;
            long angle = (long)before - 1 + e + (opposite ? angles / 2 : 0);
            angle = (angle % angles + angles) % angles;
            long place = (row * angles + angle) * rays + radius;
            double weight = outer * circle[e] * ray[f];
            for (int k = 0; k < CREEP_FORCES; k++) value[k] += weight * table->force[k][place];
        }
    }
    double unit = friction * contact[CREEP_NORMAL_FORCE];
    double tangential = unit * value[1], normal = contact[CREEP_NORMAL_FORCE] * value[2];
    forces[CREEP_F_X] = unit * value[0];
    forces[CREEP_F_Y] = tangential * cosine - normal * sine;
    forces[CREEP_F_Z] = tangential * sine + normal * cosine;
    forces[CREEP_M_N] = unit * contact[CREEP_HALF_SIZE] * value[3];
    forces[CREEP_P_MAX] = contact[CREEP_CONTACT_P_MAX] * value[4];
    forces[CREEP_WORK] = unit * saturation * (1 + creepage) * value[5];
    return 0;
}

#endif
