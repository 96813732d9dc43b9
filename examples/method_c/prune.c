/* A method of level of detail in C: it reads a pack's part hierarchy and keeps what is large enough.
 *
 *   cc -O2 -std=c99 -o prune prune.c -lm
 *   ./prune DIR/parts.bin X Y Z PIXEL KNOB kept.bin
 *
 * X Y Z is the eye [m], PIXEL the angle of a pixel [rad], KNOB how many pixels a part must cover to
 * be kept. The rule is this method's own: a part's bounding ball, seen from its nearest point, and
 * not the priority P that Blake's metric goes by. docs/packs.md has the layout of both files. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { char magic[8]; uint32_t version, models, parts, sticks, triangles, tints, instances, unused; } Head;
typedef struct { uint32_t first_part, parts, species, thins; } Model;
typedef struct {
    int32_t parent, level;
    float x, y, z, P, R, B;
    uint32_t first_inner, inner, first_leaf, leaf, first_triangle, triangles;
} Part;
typedef struct { uint32_t model, first; float x, y, z, cos, sin; } Instance;
typedef struct { uint32_t part; float width; } Kept;

static void *read_table(FILE *file, size_t size, size_t count) {
    void *table = malloc(size * count + 1);
    if (!table || fread(table, size, count, file) != count) { fprintf(stderr, "prune: a file cut short\n"); exit(2); }
    return table;
}

int main(int argc, char **argv) {
    if (argc != 8) { fprintf(stderr, "usage: prune PARTS X Y Z PIXEL KNOB KEPT\n"); return 2; }
    FILE *in = fopen(argv[1], "rb"), *out = fopen(argv[7], "wb");
    if (!in || !out) { fprintf(stderr, "prune: cannot open %s\n", in ? argv[7] : argv[1]); return 2; }
    double x = atof(argv[2]), y = atof(argv[3]), z = atof(argv[4]), least = atof(argv[5]) * atof(argv[6]);
    Head *head = read_table(in, sizeof(Head), 1);
    if (memcmp(head->magic, "LODPARTS", 8) || head->version != 1) { fprintf(stderr, "prune: no parts.bin\n"); return 2; }
    Model *models = read_table(in, sizeof(Model), head->models);
    Part *parts = read_table(in, sizeof(Part), head->parts);
    long looks = 36L * head->sticks + 48L * head->triangles + 12L * head->tints;
    if (fseek(in, looks, SEEK_CUR)) return 2;
    Instance *instances = read_table(in, sizeof(Instance), head->instances);
    char *kept = malloc(head->parts + 1);
    unsigned long count = 0, all = 0;
    fwrite("LODKEPT1", 1, 8, out);
    for (uint32_t i = 0; i < head->instances; i++) {
        Instance *at = &instances[i];
        Model *model = &models[at->model];
        Part *own = &parts[model->first_part];
        all += model->parts;
        for (uint32_t k = 0; k < model->parts; k++) { /* owners stand before their parts */
            Part *p = &own[k];
            kept[k] = 0;
            if (p->parent >= 0 && !kept[p->parent]) continue;
            double dx = at->x + at->cos * p->x - at->sin * p->y - x;
            double dy = at->y + at->sin * p->x + at->cos * p->y - y;
            double dz = at->z + p->z - z, distance = sqrt(dx * dx + dy * dy + dz * dz) - p->B;
            if (distance > 0 && 2 * p->B < least * distance) continue;
            Kept record = {at->first + k, 1.0f};
            kept[k] = 1;
            count += fwrite(&record, sizeof record, 1, out);
        }
    }
    if (fclose(out)) { perror("prune"); return 1; }
    printf("{\"kept\": %lu, \"parts\": %lu}\n", count, all);
    return 0;
}
