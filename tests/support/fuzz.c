/* Random calls of the C API of an FMU of FMI 2.0 or 3.0 (-DFMI=2 or 3): fuzz LIBRARY TOKEN CALLS SEED VARIABLES
 *
 * Arrays are allocated to the byte, so that valgrind sees an access beyond them. Prints calls made, calls that were
 * answered OK, steps made; an answer outside the standard's range ends the program with 1. */
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if FMI == 2
#define NAME(x) "fmi2" x
#define STATE "FMUstate"
#define REAL "Real"
#define INTEGER "Integer"
#define DESERIALISE "DeSerialize"
#else
#define NAME(x) "fmi3" x
#define STATE "FMUState"
#define REAL "Float64"
#define INTEGER "Int32"
#define DESERIALISE "Deserialize"
#endif

enum { KEPT = 3, LONGEST = 5 };
typedef int (*function)();

static uint64_t seed;
static void *library, *instance, *kept[KEPT];
static const char *token;
static uint32_t variables;

static uint64_t any(void) {
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return seed;
}
static uint64_t below(uint64_t n) { return any() % n; }

static double number(void) {
    static const double odd[] = {0, 1, -1, 5e-6, 1e-5, 1e-3, 60e3, 0.3, 1e9, 1e300, -1e300, NAN, INFINITY, 5e-324};
    return below(3) ? odd[below(sizeof odd / sizeof *odd)] : (double)(int64_t)any() * 1e-19;
}
static uint32_t reference(void) { return below(20) ? (uint32_t)below(variables + 3) : (uint32_t)any(); }
static function find(const char *name) {
    void *found = dlsym(library, name);
    if (!found) { fprintf(stderr, "no function %s\n", name); exit(2); }
    return (function)found;
}
static void *exactly(size_t bytes) { return malloc(bytes ? bytes : 1); }

static void *make(const char *with) {
#if FMI == 2
    typedef struct { void *logger, *allocate, *release, *finished, *environment; } callbacks;
    static const callbacks none;
    void *(*f)(const char *, int, const char *, const char *, const void *, int, int) = dlsym(library, "fmi2Instantiate");
    return f("x", 1, with, "", below(2) ? &none : NULL, 0, (int)below(2));
#else
    void *(*f)(const char *, const char *, const char *, bool, bool, bool, bool, const void *, size_t, void *, void *,
               void *) = dlsym(library, "fmi3InstantiateCoSimulation");
    return f("x", with, "", false, below(2), false, false, NULL, 0, NULL, NULL, NULL);
#endif
}

static int enter(double start, double stop) {
#if FMI == 2
    int (*setup)(void *, int, double, double, int, double) = (void *)find(NAME("SetupExperiment"));
    int (*f)(void *) = (void *)find(NAME("EnterInitializationMode"));
    int status = setup(instance, 0, 0.0, start, 1, stop);
    return status ? status : f(instance);
#else
    int (*f)(void *, bool, double, double, bool, double) = (void *)find(NAME("EnterInitializationMode"));
    return f(instance, false, 0.0, start, true, stop);
#endif
}

static int step(double time, double h) {
#if FMI == 2
    int (*f)(void *, double, double, int) = (void *)find(NAME("DoStep"));
    return f(instance, time, h, 1);
#else
    int (*f)(void *, double, double, bool, bool *, bool *, bool *, double *) = (void *)find(NAME("DoStep"));
    bool a, b, c;
    double last;
    return f(instance, time, h, true, &a, &b, &c, &last);
#endif
}

static int exchange(const char *what, size_t width) {
    char name[40];
    snprintf(name, sizeof name, "fmi%d%s", FMI, what);
    size_t count = below(LONGEST);
    uint32_t *references = exactly(count * sizeof *references);
    char *values = exactly(count * width);
    for (size_t k = 0; k < count; k++) {
        references[k] = reference();
        if (width == sizeof(double)) ((double *)values)[k] = number();
        else if (width == sizeof(int32_t)) ((int32_t *)values)[k] = (int32_t)any();
        else values[k] = (char)below(2);
    }
    if (!below(500)) free(values), values = NULL;
#if FMI == 2
    int (*f)(void *, uint32_t *, size_t, void *) = (void *)find(name);
    int status = f(instance, references, count, values);
#else
    int (*f)(void *, uint32_t *, size_t, void *, size_t) = (void *)find(name);
    int status = f(instance, references, count, values, below(50) ? count : 0);
#endif
    free(references), free(values);
    return status;
}

static int differentiate(void) {
    size_t n = below(LONGEST), m = below(LONGEST);
    uint32_t *unknown = exactly(n * 4), *known = exactly(m * 4);
    double *change = exactly(m * 8), *result = exactly(n * 8);
    for (size_t k = 0; k < n; k++) unknown[k] = reference();
    for (size_t k = 0; k < m; k++) known[k] = reference(), change[k] = number();
#if FMI == 2
    int (*f)(void *, uint32_t *, size_t, uint32_t *, size_t, double *, double *) =
        (void *)find(NAME("GetDirectionalDerivative"));
    int status = f(instance, unknown, n, known, m, change, result);
#else
    int (*f)(void *, uint32_t *, size_t, uint32_t *, size_t, double *, size_t, double *, size_t) =
        (void *)find(NAME("GetDirectionalDerivative"));
    int status = f(instance, unknown, n, known, m, change, m, result, n);
#endif
    free(unknown), free(known), free(change), free(result);
    return status;
}

static int serialise(void) {
    int (*measure)(void *, void *, size_t *) = (void *)find(NAME("Serialized" STATE "Size"));
    int (*write)(void *, void *, char *, size_t) = (void *)find(NAME("Serialize" STATE));
    int (*read)(void *, const char *, size_t, void **) = (void *)find(NAME("") DESERIALISE STATE);
    void **place = &kept[below(KEPT)];
    size_t size = 0;
    int status = measure(instance, *place, &size);
    if (status) return status;
    char *data = exactly(size);
    status = write(instance, *place, data, size);
    size_t length = below(4) ? size : below(size + 1); /* whole, or cut into an array of its own */
    char *copy = exactly(length);
    memcpy(copy, data, length);
    if (length && !below(3)) copy[below(length)] ^= (char)(1 << below(8));
    if (!status) status = read(instance, copy, length, place);
    free(data), free(copy);
    return status;
}

static int state(const char *what, bool address) {
    char name[40];
    snprintf(name, sizeof name, "fmi%d%s" STATE, FMI, what);
    void **place = &kept[below(KEPT)];
    if (address) return ((int (*)(void *, void **))find(name))(instance, place);
    return ((int (*)(void *, void *))find(name))(instance, *place);
}

static int plain(const char *what) {
    char name[40];
    snprintf(name, sizeof name, "fmi%d%s", FMI, what);
    return ((int (*)(void *))find(name))(instance);
}

static void discard(void) {
    for (int k = 0; k < KEPT; k++) ((int (*)(void *, void **))find(NAME("Free" STATE)))(instance, &kept[k]), kept[k] = NULL;
    ((void (*)(void *))find(NAME("FreeInstance")))(instance);
}

static double now;
static long steps;

static int call(void) {
    switch (below(32)) {
    case 0: return enter(number(), number());
    case 1: return plain("ExitInitializationMode");
    case 2: return below(8) ? 0 : plain("Terminate");
    case 3: case 4: now = 0; return plain("Reset");
    case 5: /* an orderly start */
        now = 0;
        return plain("Reset") || enter(0.0, 1.0) || plain("ExitInitializationMode");
    case 6: return exchange("Set" INTEGER, 4);
    case 7: return exchange("Get" INTEGER, 4);
#if FMI == 2
    case 8: return exchange("SetBoolean", 4);
    case 9: return exchange("GetBoolean", 4);
#else
    case 8: return exchange("SetBoolean", 1);
    case 9: return exchange("GetBoolean", 1);
#endif
    case 10: case 11: return exchange("Set" REAL, 8);
    case 12: case 13: return exchange("Get" REAL, 8);
    case 14: return differentiate();
    case 15: case 16: return state("Get", true);
    case 17: case 18: return state("Set", false);
    case 19: return state("Free", true);
    case 20: return serialise();
    case 21: { /* any step but those that take the coupled system long */
        double h = number();
        return step(number(), h > 1e-3 && h < 1e6 ? 1e-3 : h);
    }
    case 22: /* another instance, and one that is refused */
        if (below(10)) return 0;
        discard();
        if (make("not the token")) return 9;
        instance = make(token);
        return instance ? (now = 0, 0) : 9;
    default: { /* go on */
        int status = step(now, 5e-6);
        if (!status) now += 5e-6, steps++;
        return status;
    }
    }
}

int main(int count, char **arguments) {
    if (count != 6) return 2;
    library = dlopen(arguments[1], RTLD_NOW);
    if (!library) { fprintf(stderr, "%s\n", dlerror()); return 2; }
    token = arguments[2];
    long calls = atol(arguments[3]), fine = 0;
    seed = (uint64_t)atol(arguments[4]) * 0x9E3779B97F4A7C15u + 1;
    variables = (uint32_t)atol(arguments[5]);
    instance = make(token);
    if (!instance) return 2;
    for (long k = 0; k < calls; k++) {
        int status = call();
        if (status < 0 || status > 3) { fprintf(stderr, "call %ld answered %d\n", k, status); return 1; }
        fine += status == 0;
    }
    discard();
    printf("%ld %ld %ld\n", calls, fine, steps);
    return 0;
}
