/* Co-simulation slaves of FMI 2.0 or 3.0 (-DFMI=3) with traits that FMUs are tested by; the GUID or token says which:
   Dahlquist, VanDerPol, BouncingBall (state events), Stair (time events, ends the simulation), Feedthrough (all types,
   texts too), Resource (reads a file), Early and Stuck (return early), Events (does not do without event mode), StateSpace (FMI 3.0: arrays that structural parameters resize). Explicit Euler with
   a step of their own, whatever the communication step is. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if FMI == 3
#include "fmi3Functions.h"
#else
#include "fmi2Functions.h"
#endif
#define N 8
typedef struct { char kind[32], text[2][64]; double r[300], t; long long i[20]; int ended, configuring; } Model;
/* StateSpace: sizes m, n, r in i[1..3]; A, B, C, D, x0, u, y, x at r + 40 k, row by row */
static double *part(Model *m, int k) { return m->r + 40 * k; }
static void rates(Model *m, double *d) {
  double *r = m->r;
  if (!strcmp(m->kind, "Dahlquist")) d[1] = -r[3] * r[1];
  if (!strcmp(m->kind, "VanDerPol")) { d[1] = r[3]; d[3] = r[5] * ((1 - r[1] * r[1]) * r[3]) - r[1]; }
  if (!strcmp(m->kind, "BouncingBall")) { d[1] = r[3]; d[3] = r[5]; }
}
static void inner(Model *m, double h) {
  double d[N] = {0};
  if (!strcmp(m->kind, "StateSpace")) {
    int nm = m->i[1], n = m->i[2];
    double dx[6] = {0};
    for (int a = 0; a < n; a++) {
      for (int b = 0; b < n; b++) dx[a] += part(m, 0)[a * n + b] * part(m, 6)[b];
      for (int b = 0; b < nm; b++) dx[a] += part(m, 1)[a * nm + b] * part(m, 4)[b];
    }
    for (int a = 0; a < n; a++) part(m, 6)[a] += h * dx[a];
    return;
  }
  rates(m, d);
  for (int k = 1; k < N; k++) m->r[k] += h * d[k];
  if (!strcmp(m->kind, "BouncingBall") && m->r[1] <= 0 && m->r[3] < 0) { m->r[1] = 2.2250738585072014E-308; m->r[3] = -m->r[3] * m->r[6]; }
}
static void look(Model *m) {
  double d[N] = {0};
  rates(m, d);
  if (!strcmp(m->kind, "Dahlquist")) m->r[2] = d[1];
  if (!strcmp(m->kind, "VanDerPol") || !strcmp(m->kind, "BouncingBall")) { m->r[2] = d[1]; m->r[4] = d[3]; }
  if (!strcmp(m->kind, "Feedthrough")) { m->r[2] = m->r[1]; for (int k = 3; k <= 13; k += 2) m->i[k + 1] = m->i[k]; strcpy(m->text[1], m->text[0]); }
  if (!strcmp(m->kind, "StateSpace")) for (int a = 0; a < m->i[3]; a++) {
    part(m, 5)[a] = 0;
    for (int b = 0; b < m->i[2]; b++) part(m, 5)[a] += part(m, 2)[a * m->i[2] + b] * part(m, 6)[b];
    for (int b = 0; b < m->i[1]; b++) part(m, 5)[a] += part(m, 3)[a * m->i[1] + b] * part(m, 4)[b];
  }
}
static void *make(const char *kind, const char *resources) {
  Model *m = calloc(1, sizeof(Model));
  strncpy(m->kind, kind, 31);
  strcpy(m->text[0], "none");
  double start[][N] = {{0, 1, 0, 1}, {0, 2, 0, 0, 0, 1}, {0, 1, 0, 0, 0, -9.81, 0.7}};
  const char *kinds[] = {"Dahlquist", "VanDerPol", "BouncingBall"};
  for (int k = 0; k < 3; k++) if (!strcmp(kind, kinds[k])) memcpy(m->r, start[k], sizeof start[k]);
  if (!strcmp(kind, "Stair")) m->i[1] = 1;
  if (!strcmp(kind, "StateSpace")) { m->i[1] = m->i[2] = m->i[3] = 3; for (int k = 0; k < 4; k++) for (int a = 0; a < 3; a++) part(m, k)[4 * a] = 1; }
  if (!strcmp(kind, "Resource")) {
    char path[4096];
    snprintf(path, sizeof path, "%s/y.txt", strncmp(resources, "file://", 7) ? resources : resources + 7);
    FILE *f = fopen(path, "r");
    if (!f) { free(m); return NULL; }
    m->i[1] = fgetc(f);
    fclose(f);
  }
  return m;
}
static void step(Model *m, double to) {
  double own = !strcmp(m->kind, "Stair") ? 1.0 : !strcmp(m->kind, "Dahlquist") ? 0.1 : !strcmp(m->kind, "StateSpace") ? 1.0 : 0.01;
  while (m->t + own <= to + 1e-9) {
    m->t += own;
    if (strcmp(m->kind, "Stair")) inner(m, own);
    else if (m->i[1] < 10) m->i[1]++;
    else m->ended = 1;
  }
}
#if FMI == 3
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean a, fmi3Boolean b, fmi3Boolean c,
    fmi3Boolean d, const fmi3ValueReference r[], size_t n, fmi3InstanceEnvironment e, fmi3LogMessageCallback l, fmi3IntermediateUpdateCallback u) {
  return !strcmp(token, "Events") && !c ? NULL : make(token, resources); }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *d, fmi3Boolean *e, fmi3Boolean *f, fmi3Float64 *t) {
  ((Model *)c)->i[2]++; *a = *b = *d = *e = *f = 0; return fmi3OK; }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return fmi3OK; }
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { Model *m = c; memcpy(part(m, 6), part(m, 7), 40 * sizeof(double) * !strcmp(m->kind, "StateSpace")); return fmi3OK; }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { ((Model *)c)->configuring = 1; return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { Model *m = c; m->configuring = 0; for (int k = 0; k < 4; k++) for (int a = 0; a < 40; a++) part(m, k)[a] = 0.1 * (a + k); return 0; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean f, fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early,
    fmi3Float64 *last) { Model *m = c;
  if (!strcmp(m->kind, "Early") || !strcmp(m->kind, "Stuck")) { /* comes back half-way, or where it was */
    double to = !strcmp(m->kind, "Stuck") ? t : m->configuring ? t + h : t + h / 2;
    m->configuring = !m->configuring; m->r[1] += to - t; m->i[2]++;
    *event = *end = 0; *early = to < t + h; *last = to; return fmi3OK; }
  if (!strcmp(m->kind, "Events")) { m->r[1] = t + h; *event = 1; *end = *early = 0; *last = t + h; return fmi3OK; }
  step(m, t + h); *event = *early = 0; *end = m->ended; *last = t + h; return fmi3OK; }
static int size(Model *m, int v) { int s[] = {m->i[2] * m->i[2], m->i[2] * m->i[1], m->i[3] * m->i[2], m->i[3] * m->i[1], m->i[1], m->i[3], m->i[2], m->i[2]};
  return strcmp(m->kind, "StateSpace") ? 1 : s[v - 4]; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], size_t nx) {
  Model *m = c; size_t k = 0; look(m);
  for (size_t j = 0; j < n; j++) { double *p = strcmp(m->kind, "StateSpace") ? m->r + v[j] : part(m, v[j] - 4); for (int e = 0; e < size(m, v[j]); e++) { if (k >= nx) return fmi3Error; x[k++] = p[e]; } }
  return k == nx ? fmi3OK : fmi3Error; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[], size_t nx) {
  Model *m = c; size_t k = 0;
  for (size_t j = 0; j < n; j++) { double *p = strcmp(m->kind, "StateSpace") ? m->r + v[j] : part(m, v[j] - 4); for (int e = 0; e < size(m, v[j]); e++) { if (k >= nx) return fmi3Error; p[e] = x[k++]; } }
  return k == nx ? fmi3OK : fmi3Error; }
#define PAIR(Name, Type) \
  fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference v[], size_t n, Type x[], size_t nx) { look(c); for (size_t k = 0; k < n; k++) x[k] = (Type)((Model *)c)->i[v[k]]; return fmi3OK; } \
  fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference v[], size_t n, const Type x[], size_t nx) { for (size_t k = 0; k < n; k++) ((Model *)c)->i[v[k]] = (long long)x[k]; return fmi3OK; }
PAIR(Int32, fmi3Int32) PAIR(Int64, fmi3Int64) PAIR(UInt64, fmi3UInt64) PAIR(Boolean, fmi3Boolean) PAIR(UInt8, fmi3UInt8) PAIR(Int16, fmi3Int16)
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3String x[], size_t nx) { look(c); for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->text[v[k] - 15]; return fmi3OK; }
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3String x[], size_t nx) { for (size_t k = 0; k < n; k++) strncpy(((Model *)c)->text[v[k] - 15], x[k], 63); return fmi3OK; }
#else
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f, fmi2Boolean a,
    fmi2Boolean b) { return make(guid, resources); }
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real e, fmi2Real start, fmi2Boolean s, fmi2Real stop) { return fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean f) { Model *m = c; step(m, t + h); return m->ended ? fmi2Discard : fmi2OK; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *x) { *x = ((Model *)c)->ended; return fmi2OK; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *x) { *x = ((Model *)c)->t; return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real x[]) { look(c); for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->r[v[k]]; return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real x[]) { for (size_t k = 0; k < n; k++) ((Model *)c)->r[v[k]] = x[k]; return fmi2OK; }
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Integer x[]) { look(c); for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->i[v[k]]; return fmi2OK; }
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer x[]) { for (size_t k = 0; k < n; k++) ((Model *)c)->i[v[k]] = x[k]; return fmi2OK; }
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Boolean x[]) { return fmi2GetInteger(c, v, n, x); }
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Boolean x[]) { return fmi2SetInteger(c, v, n, x); }
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2String x[]) { look(c); for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->text[v[k] - 15]; return fmi2OK; }
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2String x[]) { for (size_t k = 0; k < n; k++) strncpy(((Model *)c)->text[v[k] - 15], x[k], 63); return fmi2OK; }
#endif
