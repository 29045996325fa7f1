/* A rail as somebody else writes it in C, FMI 2.0 or 3.0 (-DFMI=3): modes in resources/modes.txt, stepped exactly.
   The file: number of modes, newtons per unit of force, metres per unit of length; then per mode frequency [Hz], damping
   ratio and the four numbers of its shape. References: 1 to 4 forces, 5 to 8 velocities, 9 to 12 displacements; with
   FMI 3.0 the same as three arrays of references 1, 5 and 9. Moments and rotations are in N m and rad. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if FMI == 3
#include "fmi3Functions.h"
#else
#include "fmi2Functions.h"
#endif
typedef struct { double w, z, s[4], v, u, vv, vu, vf, uv, uu, uf; } Mode;
typedef struct { int n; double newton, metre, h, r[13]; Mode *mode; } Rail;
static void *make(const char *resources) {
  char path[4096];
  Rail *m = calloc(1, sizeof(Rail));
  snprintf(path, sizeof path, "%s/modes.txt", strncmp(resources, "file://", 7) ? resources : resources + 7);
  FILE *f = fopen(path, "r");
  if (!f || fscanf(f, "%d %lf %lf", &m->n, &m->newton, &m->metre) != 3) return NULL;
  m->mode = calloc(m->n, sizeof(Mode));
  for (int k = 0; k < m->n; k++) {
    Mode *a = m->mode + k;
    if (fscanf(f, "%lf %lf %lf %lf %lf %lf", &a->w, &a->z, a->s, a->s + 1, a->s + 2, a->s + 3) != 6) return NULL;
    a->w *= 2 * acos(-1.0);
  }
  fclose(f);
  return m;
}
static void clear(void *c) { free(((Rail *)c)->mode); free(c); }
static void tabulate(Mode *a, double h) { /* roots p, q of s^2 + 2 z w s + w^2, or a real and an imaginary part */
  double w = a->w, d = a->z * w, g, dg, way;
  if (a->z < 1) {
    double b = w * sqrt(1 - a->z * a->z), e = exp(-d * h), half = sin(b * h / 2);
    g = e * sin(b * h) / b;
    dg = e * cos(b * h) - d * g;
    way = (2 * e * half * half - expm1(-d * h) - d * g) / (w * w);
  } else {
    double b = w * sqrt(a->z * a->z - 1), p = -(d + b), q = w * w / p;
    g = (exp(q * h) - exp(p * h)) / (q - p);
    dg = (q * exp(q * h) - p * exp(p * h)) / (q - p);
    way = (expm1(q * h) / q - expm1(p * h) / p) / (q - p);
  }
  a->vv = dg; a->vu = -w * w * g; a->vf = g;
  a->uv = g; a->uu = dg + 2 * d * g; a->uf = way;
}
static void step(Rail *m, double h) {
  double sum[8] = {0};
  if (h != m->h) for (int k = 0; k < m->n; k++) tabulate(m->mode + k, h);
  m->h = h;
  for (int k = 0; k < m->n; k++) {
    Mode *a = m->mode + k;
    double f = a->s[3] * m->r[4];
    for (int j = 0; j < 3; j++) f += a->s[j] * m->newton * m->r[1 + j];
    double v = a->vv * a->v + a->vu * a->u + a->vf * f;
    a->u = a->uv * a->v + a->uu * a->u + a->uf * f;
    a->v = v;
    for (int j = 0; j < 4; j++) { sum[j] += a->s[j] * a->v; sum[4 + j] += a->s[j] * a->u; }
  }
  for (int j = 0; j < 8; j++) m->r[5 + j] = j % 4 == 3 ? sum[j] : sum[j] / m->metre;
}
#if FMI == 3
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean a, fmi3Boolean b,
    fmi3Boolean c, fmi3Boolean d, const fmi3ValueReference r[], size_t n, fmi3InstanceEnvironment e, fmi3LogMessageCallback l,
    fmi3IntermediateUpdateCallback u) { return make(resources); }
void fmi3FreeInstance(fmi3Instance c) { clear(c); }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean f, fmi3Boolean *event, fmi3Boolean *end,
    fmi3Boolean *early, fmi3Float64 *last) { step(c, h); *event = *end = *early = 0; *last = t + h; return fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], size_t nx) {
  if (nx != 4 * n) return fmi3Error;
  for (size_t k = 0; k < nx; k++) x[k] = ((Rail *)c)->r[v[k / 4] + k % 4];
  return fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[], size_t nx) {
  if (nx != 4 * n) return fmi3Error;
  for (size_t k = 0; k < nx; k++) ((Rail *)c)->r[v[k / 4] + k % 4] = x[k];
  return fmi3OK; }
#else
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *f, fmi2Boolean a, fmi2Boolean b) { return make(resources); }
void fmi2FreeInstance(fmi2Component c) { clear(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real e, fmi2Real a, fmi2Boolean s, fmi2Real b) { return fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean f) { step(c, h); return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real x[]) {
  for (size_t k = 0; k < n; k++) x[k] = ((Rail *)c)->r[v[k]];
  return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real x[]) {
  for (size_t k = 0; k < n; k++) ((Rail *)c)->r[v[k]] = x[k];
  return fmi2OK; }
#endif
