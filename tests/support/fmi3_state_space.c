/* FMI 3.0 co-simulation: x' = A x + B u, y = C x + D u, exact for held inputs; sizes, token and starts are defined before. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <signal.h>
#include "fmi3FunctionTypes.h"
#define EXPORT __attribute__((visibility("default")))
#define Z (N + M)
typedef struct {
  double u[M], y[P], A[N * N], B[N * M], C[P * N], D[P * M], x[N], h, phi[Z * Z];
  int steps, enable, fault, fault_step;
} Model;
typedef struct { Model m; fmi3LogMessageCallback log; fmi3InstanceEnvironment env; } Instance;

static void product(const double *a, const double *b, double *c) {
  for (int i = 0; i < Z; i++) for (int j = 0; j < Z; j++) {
    double s = 0; for (int k = 0; k < Z; k++) s += a[i * Z + k] * b[k * Z + j];
    c[i * Z + j] = s;
  }
}
static void exponential(Model *m, double h) {  /* of [[A, B], [0, 0]] h: scaled, Taylor, squared */
  double *a = calloc(3 * Z * Z, sizeof(double)), *t = a + Z * Z, *s = t + Z * Z, largest = 0;
  for (int i = 0; i < N; i++) {
    double row = 0;
    for (int j = 0; j < N; j++) row += fabs(a[i * Z + j] = m->A[i * N + j] * h);
    for (int j = 0; j < M; j++) a[i * Z + N + j] = m->B[i * M + j] * h;
    if (row > largest) largest = row;
  }
  int squarings = 0;
  while (largest > 0.1) { largest /= 2; squarings++; }
  for (int i = 0; i < Z * Z; i++) a[i] = ldexp(a[i], -squarings);
  memset(m->phi, 0, sizeof m->phi); memset(t, 0, Z * Z * sizeof(double));
  for (int i = 0; i < Z; i++) m->phi[i * Z + i] = t[i * Z + i] = 1;
  for (int k = 1; k < 14; k++) {
    product(t, a, s);
    for (int i = 0; i < Z * Z; i++) m->phi[i] += (t[i] = s[i] / k);
  }
  for (int k = 0; k < squarings; k++) { product(m->phi, m->phi, s); memcpy(m->phi, s, sizeof m->phi); }
  m->h = h; free(a);
}
static void outputs(Model *m) {
  for (int i = 0; i < P; i++) {
    m->y[i] = 0;
    for (int k = 0; k < N; k++) m->y[i] += m->C[i * N + k] * m->x[k];
    for (int k = 0; k < M; k++) m->y[i] += m->D[i * M + k] * m->u[k];
  }
}
EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT fmi3Instance fmi3InstantiateCoSimulation(const char *name, const char *token,
    const char *path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean event, fmi3Boolean early, const fmi3ValueReference r[], size_t n,
    fmi3InstanceEnvironment env, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
  if (strcmp(token, TOKEN)) return NULL;
  Instance *i = calloc(1, sizeof(Instance));
  double A[] = A_START, B[] = B_START, C[] = C_START, D[] = D_START;
  memcpy(i->m.A, A, sizeof A); memcpy(i->m.B, B, sizeof B); memcpy(i->m.C, C, sizeof C); memcpy(i->m.D, D, sizeof D);
  i->m.enable = 1; i->m.fault_step = 1; i->log = log; i->env = env;
  return i;
}
EXPORT void fmi3FreeInstance(fmi3Instance i) { free(i); }
EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean a, double b, double c, fmi3Boolean d, double e) {
  return fmi3OK;
}
EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { outputs(&((Instance *)i)->m); return fmi3OK; }
EXPORT fmi3Status fmi3Terminate(fmi3Instance i) { return fmi3OK; }
EXPORT fmi3Status fmi3Reset(fmi3Instance i) { return fmi3Error; }
static double *array(Model *m, fmi3ValueReference r, size_t *n) {
  switch (r) {
    case 1: *n = M; return m->u;
    case 2: *n = P; outputs(m); return m->y;
    case 3: *n = N * N; return m->A;
    case 4: *n = N * M; return m->B;
    case 5: *n = P * N; return m->C;
    case 6: *n = P * M; return m->D;
    case 7: *n = N; return m->x;
    default: return NULL;
  }
}
static fmi3Status reals(Instance *i, const fmi3ValueReference r[], size_t n, double v[], size_t nv, int set) {
  size_t done = 0, size;
  for (size_t k = 0; k < n; k++) {
    double *p = array(&i->m, r[k], &size);
    if (!p || done + size > nv) { i->log(i->env, fmi3Error, "error", "no such Float64, or the wrong number of values"); return fmi3Error; }
    if (set) memcpy(p, v + done, size * sizeof(double)); else memcpy(v + done, p, size * sizeof(double));
    done += size;
  }
  return done == nv ? fmi3OK : fmi3Error;
}
EXPORT fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference r[], size_t n, const double v[], size_t nv) {
  return reals(i, r, n, (double *)v, nv, 1);
}
EXPORT fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference r[], size_t n, double v[], size_t nv) {
  return reals(i, r, n, v, nv, 0);
}
EXPORT fmi3Status fmi3GetFloat32(fmi3Instance i, const fmi3ValueReference r[], size_t n, float v[], size_t nv) {
  v[0] = (float)((Instance *)i)->m.y[0]; return r[0] == 11 ? fmi3OK : fmi3Error;
}
static int *whole(Model *m, fmi3ValueReference r) { return r == 8 ? &m->steps : r == 12 ? &m->fault : r == 13 ? &m->fault_step : NULL; }
EXPORT fmi3Status fmi3SetInt32(fmi3Instance i, const fmi3ValueReference r[], size_t n,
    const fmi3Int32 v[], size_t nv) {
  for (size_t k = 0; k < n; k++) { int *p = whole(&((Instance *)i)->m, r[k]); if (!p) return fmi3Error; *p = v[k]; }
  return fmi3OK;
}
EXPORT fmi3Status fmi3GetInt32(fmi3Instance i, const fmi3ValueReference r[], size_t n, fmi3Int32 v[], size_t nv) {
  for (size_t k = 0; k < n; k++) { int *p = whole(&((Instance *)i)->m, r[k]); if (!p) return fmi3Error; v[k] = *p; }
  return fmi3OK;
}
EXPORT fmi3Status fmi3SetBoolean(fmi3Instance i, const fmi3ValueReference r[], size_t n, const fmi3Boolean v[], size_t nv) {
  ((Instance *)i)->m.enable = v[0]; return r[0] == 10 ? fmi3OK : fmi3Error;
}
EXPORT fmi3Status fmi3GetBoolean(fmi3Instance i, const fmi3ValueReference r[], size_t n, fmi3Boolean v[], size_t nv) {
  v[0] = ((Instance *)i)->m.y[0] > 0; return r[0] == 9 ? fmi3OK : fmi3Error;
}
EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, double t, double h, fmi3Boolean final,
    fmi3Boolean *event, fmi3Boolean *end,
    fmi3Boolean *early, double *last) {
  Instance *i = instance; Model *m = &i->m; double x[N];
  *event = *end = *early = 0; *last = t + h;
  if (++m->steps >= m->fault_step && m->fault) {
    i->log(i->env, fmi3Error, "error", "fault on demand");
    switch (m->fault) {
      case 1: return fmi3Discard;
      case 2: return fmi3Error;
      case 3: return fmi3Fatal;
      case 4: m->x[0] = NAN; outputs(m); return fmi3OK;
      case 5: *end = 1; return fmi3OK;
      case 6: raise(SIGSEGV);
      default: for (;;) sleep(1);
    }
  }
  if (m->h != h) exponential(m, h);
  for (int a = 0; a < N; a++) {
    x[a] = 0;
    for (int k = 0; k < N; k++) x[a] += m->phi[a * Z + k] * m->x[k];
    for (int k = 0; k < M; k++) x[a] += m->phi[a * Z + N + k] * m->u[k] * m->enable;
  }
  memcpy(m->x, x, sizeof x); outputs(m);
  return fmi3OK;
}
EXPORT fmi3Status fmi3GetFMUState(fmi3Instance i, fmi3FMUState *s) {
  if (!*s) *s = malloc(sizeof(Model)); memcpy(*s, &((Instance *)i)->m, sizeof(Model)); return fmi3OK;
}
EXPORT fmi3Status fmi3SetFMUState(fmi3Instance i, fmi3FMUState s) {
  memcpy(&((Instance *)i)->m, s, sizeof(Model)); return fmi3OK;
}
EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance i, fmi3FMUState *s) { free(*s); *s = NULL; return fmi3OK; }
EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState s, size_t *n) {
  *n = sizeof(Model); return fmi3OK;
}
EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState s, fmi3Byte b[], size_t n) {
  memcpy(b, s, n); return fmi3OK;
}
EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const fmi3Byte b[], size_t n, fmi3FMUState *s) {
  *s = malloc(n); memcpy(*s, b, n); return fmi3OK;
}
