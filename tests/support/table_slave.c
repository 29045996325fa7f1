/* A co-simulation slave of FMI 2.0 or 3.0 (-DFMI=3) that does what resources/model.txt says: slots that hold numbers,
   what they start with, and rules by which a step and a look at the outputs change them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if FMI == 3
#include "fmi3Functions.h"
#define P(name) fmi3##name
#else
#include "fmi2Functions.h"
#define P(name) fmi2##name
#endif
#define MOST 256
typedef struct { int target, terms, slot[8]; double keep, add, rate, weight[8]; char when, kind; } Rule;
typedef struct { double real[MOST]; long long whole[MOST]; } Values;
typedef struct { Values v; int rules, at_real[MOST], at_whole[MOST], size_real[MOST], size_whole[MOST]; Rule rule[MOST]; double end; } Model;

static double term(Model *m, const Rule *r, int k) { /* kinds of sources: reals below MOST, whole numbers above */
  return r->slot[k] < MOST ? m->v.real[r->slot[k]] : (double)m->v.whole[r->slot[k] - MOST];
}
static void apply(Model *m, char when, double h) {
  for (int i = 0; i < m->rules; i++) {
    const Rule *r = &m->rule[i];
    if (r->when != when) continue;
    if (r->kind == 'r') {
      double x = r->keep * m->v.real[r->target] + r->add + h * r->rate;
      for (int k = 0; k < r->terms; k++) x += r->weight[k] * term(m, r, k);
      m->v.real[r->target] = x;
    } else if (r->kind == 'w') {
      long long x = (long long)r->add + (r->keep != 0 ? m->v.whole[r->target] : 0);
      for (int k = 0; k < r->terms; k++) x += (long long)r->weight[k] * m->v.whole[r->slot[k] - MOST];
      m->v.whole[r->target] = x % 100;
    } else {
      double x = r->add;
      for (int k = 0; k < r->terms; k++) x += r->weight[k] * term(m, r, k);
      m->v.whole[r->target] = x > 0;
    }
  }
}
static int load(Model *m, const char *folder) {
  char path[4096];
  snprintf(path, sizeof path, "%s/model.txt", folder);
  FILE *f = fopen(path, "r");
  if (!f) return 0;
  int variables, reference, slot, size, starts;
  if (fscanf(f, "%d", &variables) != 1) return 0;
  while (variables-- && fscanf(f, "%d %d %d", &reference, &slot, &size) == 3) {
    if (slot < MOST) { m->at_real[reference] = slot; m->size_real[reference] = size; }
    else { m->at_whole[reference] = slot - MOST; m->size_whole[reference] = size; }
  }
  if (fscanf(f, "%d", &starts) != 1) return 0;
  for (double x; starts-- && fscanf(f, "%d %lf", &slot, &x) == 2;) { if (slot < MOST) m->v.real[slot] = x; else m->v.whole[slot - MOST] = (long long)x; }
  if (fscanf(f, "%d", &m->rules) != 1) return 0;
  for (int i = 0; i < m->rules; i++) {
    Rule *r = &m->rule[i];
    if (fscanf(f, " %c %c %d %lf %lf %lf %d", &r->when, &r->kind, &r->target, &r->keep, &r->add, &r->rate, &r->terms) != 7) return 0;
    for (int k = 0; k < r->terms; k++) if (fscanf(f, "%d %lf", &r->slot[k], &r->weight[k]) != 2) return 0;
  }
  fclose(f);
  return 1;
}
static Model *make(const char *folder) {
  Model *m = calloc(1, sizeof(Model));
  if (load(m, folder)) return m;
  free(m);
  return NULL;
}
#define LOOP(store) for (size_t k = 0, n = 0; k < nvr; k++) for (int j = 0; j < m->size_##store[vr[k]]; j++, n++)
#if FMI == 3
#define PAIR(Name, Type, store) \
  fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, Type x[], size_t nx) { \
    Model *m = c; apply(m, 'o', 0); LOOP(store) { if (n >= nx) return fmi3Error; x[n] = (Type)m->v.store[m->at_##store[vr[k]] + j]; } return fmi3OK; } \
  fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const Type x[], size_t nx) { \
    Model *m = c; LOOP(store) { if (n >= nx) return fmi3Error; m->v.store[m->at_##store[vr[k]] + j] = x[n]; } return fmi3OK; }
PAIR(Float64, fmi3Float64, real) PAIR(Float32, fmi3Float32, real)
PAIR(Int8, fmi3Int8, whole) PAIR(UInt8, fmi3UInt8, whole) PAIR(Int16, fmi3Int16, whole) PAIR(UInt16, fmi3UInt16, whole)
PAIR(Int32, fmi3Int32, whole) PAIR(UInt32, fmi3UInt32, whole) PAIR(Int64, fmi3Int64, whole) PAIR(UInt64, fmi3UInt64, whole)
PAIR(Boolean, fmi3Boolean, whole)
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference r[], size_t n, fmi3InstanceEnvironment e, fmi3LogMessageCallback l,
    fmi3IntermediateUpdateCallback u) { return make(resources); }
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 t, fmi3Float64 start, fmi3Boolean s, fmi3Float64 stop) {
  ((Model *)c)->end = s ? stop : INFINITY; return fmi3OK; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *ends, fmi3Boolean *early,
    fmi3Float64 *last) { *event = *ends = *early = 0; *last = t + h; if (t + h > ((Model *)c)->end) return fmi3Error; apply(c, 's', h); return fmi3OK; }
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) { if (!*s) *s = malloc(sizeof(Values)); memcpy(*s, c, sizeof(Values)); return fmi3OK; }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) { memcpy(c, s, sizeof(Values)); return fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { free(*s); *s = NULL; return fmi3OK; }
#else
#define PAIR(Name, Type, store) \
  fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, Type x[]) { \
    Model *m = c; apply(m, 'o', 0); LOOP(store) x[n] = (Type)m->v.store[m->at_##store[vr[k]] + j]; return fmi2OK; } \
  fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const Type x[]) { \
    Model *m = c; LOOP(store) m->v.store[m->at_##store[vr[k]] + j] = x[n]; return fmi2OK; }
PAIR(Real, fmi2Real, real) PAIR(Integer, fmi2Integer, whole) PAIR(Boolean, fmi2Boolean, whole)
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f,
    fmi2Boolean visible, fmi2Boolean logging) { return make(strncmp(resources, "file://", 7) ? resources : resources + 7); }
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real t, fmi2Real start, fmi2Boolean s, fmi2Real stop) {
  ((Model *)c)->end = s ? stop : INFINITY; return fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
  if (t + h > ((Model *)c)->end) return fmi2Error; apply(c, 's', h); return fmi2OK; }
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { if (!*s) *s = malloc(sizeof(Values)); memcpy(*s, c, sizeof(Values)); return fmi2OK; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { memcpy(c, s, sizeof(Values)); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { free(*s); *s = NULL; return fmi2OK; }
#endif
