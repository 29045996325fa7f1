/* What both FMI versions share: an instance, its variables, the checks of what is set, and calls of the kernels.

   component.h is generated for each component: tables of its variables and the sizes of its memory. The kernels come
   from their Python source: as an object file (NATIVE_KERNELS), or translated to C in kernels.c, which fmi2.c and fmi3.c
   include at their end. They also give `emit` its meaning. */

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum { PARAMETER, CALCULATED, LOCAL, INPUT, OUTPUT, INDEPENDENT } Causality;
typedef enum { REAL, INTEGER, BOOLEAN } Kind;

typedef struct {
    const char *name;
    const char *unit;
    double start, minimum, maximum;
    uint32_t place; /* in the memory of the kernels */
    uint8_t causality, kind, tunable;
} Variable;

#include "component.h"

#ifdef NATIVE_KERNELS
#define KERNEL
#else
#define KERNEL static
#endif

/* The kernels: memory holds parameters, derived, state, inputs and outputs, one after the other. */
KERNEL int32_t curvesqueal_initialise(void **result, void **error, double *memory);
KERNEL int32_t curvesqueal_do_step(void **result, void **error, double *memory, double step);
#if HAS_DERIVATIVES
KERNEL int32_t curvesqueal_differentiate(void **result, void **error, double *memory, double step, double *seed,
                                         double *sensitivity);
#endif

/* Variables FIRST(r) to BEYOND(r) - 1 have the value reference r. */
#define FIRST(reference) first_variable[(reference) - FIRST_REFERENCE]
#define BEYOND(reference) first_variable[(reference) - FIRST_REFERENCE + 1]

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

/* Bits, so that a set of phases is a mask. FAILED: a call returned an error; only reading, reset or a kept state help. */
typedef enum { INSTANTIATED = 1, INITIALISING = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16 } Phase;

/* Everything that the future depends on. The place after the kernels' memory is the time that the last step reached. */
typedef struct {
    double memory[MEMORY_SIZE + 1];
    double last_step;
    int32_t phase;
    int32_t stale; /* whether the initial outputs have to be calculated again */
} State;

typedef struct {
    State state;
    void *environment;
    void *logger;
    bool talkative;
    char *name;
    char message[512];
} Instance;

static void emit(Instance *instance, Status status, const char *category, const char *message);

/* Log a message and return the status. An error ends the run until reset or a kept state. */
static Status say(Instance *instance, Status status, const char *format, ...) {
    static const char *const categories[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                             "logStatusFatal"};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(instance->message, sizeof instance->message, format, arguments);
    va_end(arguments);
    if (status >= ERROR) {
        instance->state.phase = FAILED;
    }
    emit(instance, status, categories[status], instance->message);
    return status;
}

/* Set parameters and inputs to their start values. */
static void restart(Instance *instance) {
    memset(&instance->state, 0, sizeof instance->state);
    for (size_t i = 0; i < N_VARIABLES; i++) {
        if (variables[i].causality == PARAMETER || variables[i].causality == INPUT) {
            instance->state.memory[variables[i].place] = variables[i].start;
        }
    }
    instance->state.phase = INSTANTIATED;
    instance->state.stale = 1;
}

static Instance *create(const char *name, void *environment, void *logger, bool talkative) {
    Instance *instance = calloc(1, sizeof *instance);
    if (instance == NULL) {
        return NULL;
    }
    instance->name = calloc(strlen(name) + 1, 1);
    if (instance->name == NULL) {
        free(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    instance->environment = environment;
    instance->logger = logger;
    instance->talkative = talkative;
    restart(instance);
    return instance;
}

static void destroy(Instance *instance) {
    if (instance != NULL) {
        free(instance->name);
        free(instance);
    }
}

static const char *phase_name(int32_t phase) {
    switch (phase) {
    case INSTANTIATED: return "before initialisation";
    case INITIALISING: return "in initialisation mode";
    case STEPPING: return "in step mode";
    case TERMINATED: return "after termination";
    default: return "after an error";
    }
}

/* Return whether a call is allowed now; say so if it is not. */
static bool allowed(Instance *instance, const char *function, int phases) {
    if (instance == NULL) {
        return false;
    }
    if (!(instance->state.phase & phases)) {
        say(instance, ERROR, "%s is not allowed %s", function, phase_name(instance->state.phase));
        return false;
    }
    return true;
}

static void initialise_if_stale(Instance *instance) {
    void *result = NULL, *error = NULL;
    if (instance->state.stale) {
        curvesqueal_initialise(&result, &error, instance->state.memory);
        instance->state.stale = 0;
    }
}

/* Values as the FMI functions of each type have them. */
typedef enum { DOUBLES, INT32S, INTS, BOOLS } Form;

static inline double read_value(Form form, const void *values, size_t i) {
    switch (form) {
    case DOUBLES: return ((const double *)values)[i];
    case INT32S: return ((const int32_t *)values)[i];
    case INTS: return ((const int *)values)[i] != 0;
    default: return ((const bool *)values)[i];
    }
}

static inline void write_value(Form form, void *values, size_t i, double value) {
    switch (form) {
    case DOUBLES: ((double *)values)[i] = value; break;
    case INT32S: ((int32_t *)values)[i] = (int32_t)value; break;
    case INTS: ((int *)values)[i] = value != 0.0; break;
    default: ((bool *)values)[i] = value != 0.0; break;
    }
}

static Status refuse_kind(Instance *instance, const Variable *variable) {
    static const char *const kinds[] = {"Real", "Integer", "Boolean"};
    return say(instance, ERROR, "%s is of type %s", variable->name, kinds[variable->kind]);
}

/* Return whether a value reference exists and is of the kind; say so if it is not. */
static inline bool known(Instance *instance, uint32_t reference, Kind kind) {
    if ((uint32_t)(reference - FIRST_REFERENCE) >= N_REFERENCES) {
        say(instance, ERROR, "there is no variable with value reference %lu", (unsigned long)reference);
        return false;
    }
    if (variables[FIRST(reference)].kind != kind) {
        refuse_kind(instance, &variables[FIRST(reference)]);
        return false;
    }
    return true;
}

/* Return whether a variable may be set now to this value; say so if it may not. */
static bool settable(Instance *instance, const Variable *v, double value) {
    if (v->causality != PARAMETER && v->causality != INPUT) {
        say(instance, ERROR, "%s is calculated by the component; it cannot be set", v->name);
    } else if (instance->state.phase == STEPPING && v->causality == PARAMETER && !v->tunable) {
        say(instance, ERROR, "%s is a fixed parameter; it cannot be set after initialisation", v->name);
    } else if (!isfinite(value)) {
        say(instance, ERROR, "%s = %g: must be a finite number", v->name, value);
    } else if (value < v->minimum || value > v->maximum) {
        say(instance, ERROR, "%s = %.9g: must be in the range %g to %g %s", v->name, value, v->minimum, v->maximum,
            v->unit);
    } else {
        return true;
    }
    return false;
}

/* Set variables: all of them or, after an error, none. */
static inline Status set_values(Instance *instance, Kind kind, Form form, const uint32_t references[], size_t count,
                                const void *values, size_t n_values) {
    if (count > 0 && (references == NULL || values == NULL)) {
        return say(instance, ERROR, "no value references or no values");
    }
    size_t k = 0;
    for (size_t r = 0; r < count; r++) {
        if (!known(instance, references[r], kind)) {
            return ERROR;
        }
        for (uint32_t i = FIRST(references[r]); i < BEYOND(references[r]); i++, k++) {
            if (k >= n_values) {
                return say(instance, ERROR, "%s: %zu values are too few", variables[i].name, n_values);
            }
            double value = read_value(form, values, k);
            bool plain = variables[i].causality == INPUT && fabs(value) <= DBL_MAX;
            if (!plain && !settable(instance, &variables[i], value)) {
                return ERROR;
            }
        }
    }
    if (k != n_values) {
        return say(instance, ERROR, "%zu values are too many; %zu are wanted", n_values, k);
    }
    k = 0;
    for (size_t r = 0; r < count; r++) {
        for (uint32_t i = FIRST(references[r]); i < BEYOND(references[r]); i++, k++) {
            instance->state.memory[variables[i].place] = read_value(form, values, k);
        }
    }
    if (instance->state.phase != STEPPING) {
        instance->state.stale = 1;
    }
    return OK;
}

/* Get variables; in initialisation mode they are calculated on demand. */
static inline Status get_values(Instance *instance, Kind kind, Form form, const uint32_t references[], size_t count,
                                void *values, size_t n_values) {
    if (count > 0 && (references == NULL || values == NULL)) {
        return say(instance, ERROR, "no value references or no values");
    }
    if (instance->state.phase == INITIALISING) {
        initialise_if_stale(instance);
    }
    size_t k = 0;
    for (size_t r = 0; r < count; r++) {
        if (!known(instance, references[r], kind)) {
            return ERROR;
        }
        for (uint32_t i = FIRST(references[r]); i < BEYOND(references[r]); i++, k++) {
            if (k >= n_values) {
                return say(instance, ERROR, "%s: room for %zu values is too little", variables[i].name, n_values);
            }
            double value = instance->state.memory[variables[i].place];
            if (!(fabs(value) <= DBL_MAX)) {
                return say(instance, ERROR, "%s is not finite; an input or parameter is too large", variables[i].name);
            }
            write_value(form, values, k, value);
        }
    }
    if (k != n_values) {
        return say(instance, ERROR, "room for %zu values is too much; there are %zu", n_values, k);
    }
    return OK;
}

/* Say so if the outputs are no numbers. */
static Status check_outputs(Instance *instance, double time) {
    double sum = 0.0;
    for (size_t i = 0; i < N_OUTPUTS; i++) {
        sum += instance->state.memory[OUTPUTS_PLACE + i];
    }
    if (isfinite(sum)) {
        return OK;
    }
#ifdef FAILURE
    (void)time;
    return say(instance, ERROR, FAILURE, instance->state.memory[FAILURE_PLACE]);
#else
    return say(instance, ERROR, "the outputs at %.9g s are not finite; an input or parameter is too large", time);
#endif
}

static Status start_stepping(Instance *instance) {
    initialise_if_stale(instance);
#ifdef FAILURE
    if (check_outputs(instance, 0.0) != OK) {
        return ERROR;
    }
#endif
    instance->state.phase = STEPPING;
    return OK;
}

/* Advance by one step; the inputs are held. After an error the time stays that of the last step that succeeded. */
static Status step(Instance *instance, double time, double h) {
    void *result = NULL, *error = NULL;
    double *reached = &instance->state.memory[MEMORY_SIZE];
    if (!(h > 0.0) || !isfinite(h)) {
        return say(instance, ERROR, "step size = %g s: must be > 0 and finite", h);
    }
    if (!isfinite(time)) {
        return say(instance, ERROR, "time = %g s: must be finite", time);
    }
    if (time < *reached - 0.01 * h - 1e-12 * fabs(*reached)) { /* hosts round differently */
        return say(instance, ERROR, "time = %.12g s: must not be before %.12g s, which is reached; a kept state leads back",
                   time, *reached);
    }
    curvesqueal_do_step(&result, &error, instance->state.memory, h);
    if (check_outputs(instance, time + h) != OK) {
        return ERROR;
    }
    instance->state.last_step = h;
    *reached = time + h;
    return OK;
}

/* Directional derivative of outputs at the end of the last step with respect to the inputs. */
static Status differentiate(Instance *instance, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
                            size_t n_knowns, const double seed[], size_t n_seed, double sensitivity[],
                            size_t n_sensitivity) {
#if !HAS_DERIVATIVES
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed, (void)sensitivity;
    (void)n_sensitivity;
    return say(instance, ERROR, "directional derivatives are not offered");
#else
    double inputs[N_INPUTS] = {0.0}, outputs[N_OUTPUTS] = {0.0};
    void *result = NULL, *error = NULL;
    if (unknowns == NULL || knowns == NULL || seed == NULL || sensitivity == NULL || n_seed != n_knowns ||
        n_sensitivity != n_unknowns) {
        return say(instance, ERROR, "directional derivative: as many seeds as knowns and results as unknowns are wanted");
    }
    for (size_t i = 0; i < n_knowns; i++) {
        if (!known(instance, knowns[i], REAL)) {
            return ERROR;
        }
        const Variable *v = &variables[FIRST(knowns[i])];
        if (v->causality != INPUT) {
            return say(instance, ERROR, "%s is no input; there is no derivative with respect to it", v->name);
        }
        if (!isfinite(seed[i])) {
            return say(instance, ERROR, "seed of %s = %g: must be a finite number", v->name, seed[i]);
        }
        inputs[v->place - INPUTS_PLACE] += seed[i];
    }
    initialise_if_stale(instance);
    curvesqueal_differentiate(&result, &error, instance->state.memory, instance->state.last_step, inputs, outputs);
    for (size_t i = 0; i < n_unknowns; i++) {
        if (!known(instance, unknowns[i], REAL)) {
            return ERROR;
        }
        const Variable *v = &variables[FIRST(unknowns[i])];
        if (v->causality != OUTPUT) {
            return say(instance, ERROR, "%s is no output; it has no derivative", v->name);
        }
        sensitivity[i] = outputs[v->place - OUTPUTS_PLACE];
        if (!isfinite(sensitivity[i])) {
            return say(instance, ERROR, "the derivative of %s is not finite; a seed or an input is too large", v->name);
        }
    }
    return OK;
#endif
}

/* A kept state is a copy of `State`; as bytes it carries the token of the FMU in front and a checksum behind. */
#define SERIALIZED_SIZE (sizeof TOKEN + sizeof(State) + sizeof(uint64_t))

static Status keep(Instance *instance, const State *state, void **kept) {
    if (kept == NULL) {
        return say(instance, ERROR, "no place for the state");
    }
    if (*kept == NULL) {
        *kept = calloc(1, sizeof(State));
    }
    if (*kept == NULL) {
        return say(instance, ERROR, "out of memory");
    }
    memcpy(*kept, state, sizeof(State));
    return OK;
}

static Status restore_state(Instance *instance, const void *kept) {
    if (kept == NULL) {
        return say(instance, ERROR, "there is no state to restore");
    }
    memcpy(&instance->state, kept, sizeof(State));
    return OK;
}

/* FNV-1a, 64 bits. */
static uint64_t checksum(const char bytes[], size_t size) {
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < size; i++) {
        sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
    }
    return sum;
}

static Status state_to_bytes(Instance *instance, const void *kept, char bytes[], size_t size) {
    if (kept == NULL || bytes == NULL || size < SERIALIZED_SIZE) {
        return say(instance, ERROR, "a state of %zu bytes is wanted, with room for them", SERIALIZED_SIZE);
    }
    memcpy(bytes, TOKEN, sizeof TOKEN);
    memcpy(bytes + sizeof TOKEN, kept, sizeof(State));
    uint64_t sum = checksum(bytes, sizeof TOKEN + sizeof(State));
    memcpy(bytes + sizeof TOKEN + sizeof(State), &sum, sizeof sum);
    return OK;
}

/* Return the name of what no state can have; NULL if there is nothing. */
static const char *impossible(const State *state) {
    int32_t phase = state->phase;
    if (phase != INSTANTIATED && phase != INITIALISING && phase != STEPPING && phase != TERMINATED && phase != FAILED) {
        return "phase";
    }
    if ((state->stale != 0 && state->stale != 1) || !(state->last_step >= 0.0) || !isfinite(state->last_step) ||
        !isfinite(state->memory[MEMORY_SIZE])) {
        return "time";
    }
    for (size_t i = 0; i < N_VARIABLES; i++) {
        const Variable *v = &variables[i];
        double value = state->memory[v->place];
        if ((v->causality == PARAMETER || v->causality == INPUT) &&
            !(isfinite(value) && value >= v->minimum && value <= v->maximum)) {
            return v->name;
        }
    }
    return NULL;
}

static Status state_from_bytes(Instance *instance, const char bytes[], size_t size, void **kept) {
    State state;
    uint64_t sum;
    if (bytes == NULL || kept == NULL || size != SERIALIZED_SIZE || memcmp(bytes, TOKEN, sizeof TOKEN) != 0) {
        return say(instance, ERROR, "these %zu bytes are no state of this FMU", size);
    }
    memcpy(&sum, bytes + sizeof TOKEN + sizeof(State), sizeof sum);
    if (sum != checksum(bytes, sizeof TOKEN + sizeof(State))) {
        return say(instance, ERROR, "these bytes are a damaged state: the checksum is wrong");
    }
    memcpy(&state, bytes + sizeof TOKEN, sizeof(State));
    const char *wrong = impossible(&state);
    if (wrong != NULL) {
        return say(instance, ERROR, "these bytes are no state: %s is impossible there", wrong);
    }
    return keep(instance, &state, kept);
}
