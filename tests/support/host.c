/* A host in C: loads an FMI 2.0 library of a wheel or rail, runs two instances, restores a state, makes mistakes.
   Usage: host LIBRARY GUID. Prints the last lateral velocity; exits with the number of the check that failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(name) ((void *)LoadLibraryA(name))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)library, name))
#define SHUT(library) FreeLibrary((HMODULE)library)
#else
#include <dlfcn.h>
#define OPEN(name) dlopen(name, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#define SHUT(library) dlclose(library)
#endif

#define LOAD(name) name##TYPE *name = (name##TYPE *)FIND(library, #name)
#define CHECK(number, condition) if (!(condition)) { fprintf(stderr, "check %d\n", number); return number; }

static int errors = 0;

static void log_message(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)n, (void)c, (void)m;
    errors += s == fmi2Error;
}

int main(int argc, char **argv) {
    CHECK(1, argc == 3)
    void *library = OPEN(argv[1]);
    CHECK(2, library != NULL)
    LOAD(fmi2Instantiate); LOAD(fmi2FreeInstance); LOAD(fmi2SetupExperiment); LOAD(fmi2EnterInitializationMode);
    LOAD(fmi2ExitInitializationMode); LOAD(fmi2SetReal); LOAD(fmi2GetReal); LOAD(fmi2DoStep);
    LOAD(fmi2GetFMUstate); LOAD(fmi2SetFMUstate); LOAD(fmi2FreeFMUstate); LOAD(fmi2SerializedFMUstateSize);
    LOAD(fmi2SerializeFMUstate); LOAD(fmi2DeSerializeFMUstate); LOAD(fmi2Reset);
    fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    CHECK(3, fmi2Instantiate("x", fmi2CoSimulation, "wrong", "", &callbacks, 0, 0) == NULL && errors == 1)
    fmi2Component parts[2];
    const fmi2ValueReference force = 1, velocity = 5;
    for (int p = 0; p < 2; p++) {
        parts[p] = fmi2Instantiate("part", fmi2CoSimulation, argv[2], "", &callbacks, 0, 0);
        CHECK(4, parts[p] != NULL)
        CHECK(5, fmi2DoStep(parts[p], 0, 5e-6, 1) == fmi2Error && fmi2Reset(parts[p]) == fmi2OK)
        CHECK(6, fmi2SetupExperiment(parts[p], 0, 0, 0, 0, 0) == fmi2OK && fmi2EnterInitializationMode(parts[p]) == fmi2OK)
        CHECK(7, fmi2ExitInitializationMode(parts[p]) == fmi2OK)
    }
    fmi2FMUstate state = NULL, copy = NULL;
    double v[2], seen = 0.0;
    for (int k = 0; k < 1000; k++) {
        for (int p = 0; p < 2; p++) {
            double f = (p + 1) * 100.0 * sin(0.01 * k);
            CHECK(8, fmi2SetReal(parts[p], &force, 1, &f) == fmi2OK && fmi2DoStep(parts[p], 5e-6 * k, 5e-6, 1) == fmi2OK)
            CHECK(9, fmi2GetReal(parts[p], &velocity, 1, &v[p]) == fmi2OK)
        }
        CHECK(10, fabs(v[1] - 2 * v[0]) <= 1e-12 * fabs(v[1]) + 1e-300)
        if (k == 500) CHECK(11, fmi2GetFMUstate(parts[0], &state) == fmi2OK)
        if (k == 501) seen = v[0];
    }
    size_t size = 0;
    CHECK(12, fmi2SerializedFMUstateSize(parts[0], state, &size) == fmi2OK && size > 0)
    char *bytes = malloc(size);
    CHECK(13, fmi2SerializeFMUstate(parts[0], state, bytes, size) == fmi2OK)
    CHECK(14, fmi2DeSerializeFMUstate(parts[1], bytes, size, &copy) == fmi2OK && fmi2SetFMUstate(parts[1], copy) == fmi2OK)
    double f = 100.0 * sin(0.01 * 501), again = 0.0;
    CHECK(15, fmi2SetReal(parts[1], &force, 1, &f) == fmi2OK && fmi2DoStep(parts[1], 501 * 5e-6, 5e-6, 1) == fmi2OK)
    CHECK(16, fmi2GetReal(parts[1], &velocity, 1, &again) == fmi2OK && again == seen)
    bytes[0] ^= 1;
    CHECK(17, fmi2DeSerializeFMUstate(parts[1], bytes, size, &copy) == fmi2Error)
    CHECK(18, fmi2SetReal(NULL, &force, 1, &f) == fmi2Error && fmi2DoStep(NULL, 0, 1, 1) == fmi2Error)
    f = NAN;
    CHECK(19, fmi2SetReal(parts[0], &force, 1, &f) == fmi2Error && fmi2DoStep(parts[0], 0, 5e-6, 1) == fmi2Error)
    CHECK(20, fmi2Reset(parts[0]) == fmi2OK && fmi2FreeFMUstate(parts[0], &state) == fmi2OK && state == NULL)
    fmi2FreeFMUstate(parts[1], &copy);
    fmi2FreeInstance(parts[0]);
    fmi2FreeInstance(parts[1]);
    free(bytes);
    printf("%.17g\n", v[0]);
    return SHUT(library) != 0 && 0;
}
