/* The FMI 3.0 co-simulation functions of a component. */

#include "fmi3Functions.h"

#include "instance.h"

#define ANY (INSTANTIATED | INITIALISING | STEPPING | TERMINATED | FAILED)
#define SETTABLE (INSTANTIATED | INITIALISING | STEPPING)
#define GETTABLE (INITIALISING | STEPPING | TERMINATED | FAILED)

/* Check the phase of a call on `c`, which then goes on with `instance`. */
#define ENTER(function, phases)                                                                                        \
    Instance *instance = c;                                                                                            \
    if (!allowed(instance, function, phases)) {                                                                        \
        return fmi3Error;                                                                                              \
    }

static void emit(Instance *instance, Status status, const char *category, const char *message) {
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->logger;
    if (logger != NULL && (status != OK || instance->talkative)) {
        logger(instance->environment, (fmi3Status)status, category, message);
    }
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
    (void)count;
    (void)categories;
    ENTER("fmi3SetDebugLogging", ANY)
    instance->talkative = on;
    return fmi3OK;
}

/* Say why there is no instance. */
static fmi3Instance refuse(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, const char *message) {
    if (logger != NULL) {
        logger(environment, fmi3Error, "logStatusError", message);
    }
    return NULL;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)resources;
    (void)visible;
    (void)early_return;
    (void)intermediate;
    (void)update;
    if (name == NULL || name[0] == '\0') {
        return refuse(environment, logger, "the instance has no name");
    }
    if (token == NULL || strcmp(token, TOKEN) != 0) {
        return refuse(environment, logger, "the instantiation token is not that of the library, " TOKEN);
    }
    if (event_mode) {
        return refuse(environment, logger, "there is no event mode");
    }
    if (n_intermediate > 0) {
        return refuse(environment, logger, "there are no intermediate values; inputs are held over a step");
    }
    return create(name, environment, (void *)logger, logging);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    return refuse(environment, logger, "this FMU is for co-simulation only");
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    return refuse(environment, logger, "this FMU is for co-simulation only");
}

void fmi3FreeInstance(fmi3Instance c) { destroy(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance;
    (void)tolerance;
    ENTER("fmi3EnterInitializationMode", INSTANTIATED)
    if (!isfinite(start) || (has_stop && !(stop >= start))) {
        return (fmi3Status)say(instance, ERROR, "start time %g s, stop time %g s: must be finite and in order", start,
                               stop);
    }
    instance->state.memory[MEMORY_SIZE] = start;
    instance->state.phase = INITIALISING;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    ENTER("fmi3ExitInitializationMode", INITIALISING)
    return (fmi3Status)start_stepping(instance);
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    ENTER("fmi3Terminate", STEPPING | FAILED)
    instance->state.phase = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
    ENTER("fmi3Reset", ANY)
    restart(instance);
    return fmi3OK;
}

#define GET(name, kind, form)                                                                                          \
    fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3##name values[],           \
                             size_t n) {                                                                               \
        ENTER("fmi3Get" #name, GETTABLE)                                                                               \
        return (fmi3Status)get_values(instance, kind, form, vr, nvr, values, n);                                       \
    }
#define SET(name, kind, form)                                                                                          \
    fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3##name values[],     \
                             size_t n) {                                                                               \
        ENTER("fmi3Set" #name, SETTABLE)                                                                               \
        return (fmi3Status)set_values(instance, kind, form, vr, nvr, values, n);                                       \
    }

GET(Float64, REAL, DOUBLES)
SET(Float64, REAL, DOUBLES)
GET(Int32, INTEGER, INT32S)
SET(Int32, INTEGER, INT32S)
GET(Boolean, BOOLEAN, BOOLS)
SET(Boolean, BOOLEAN, BOOLS)

/* A type that no variable has: only a call about no variable is right. */
#define NONE(function, phases, count, text)                                                                            \
    ENTER(function, phases)                                                                                            \
    return (count) == 0 ? fmi3OK : (fmi3Status)say(instance, ERROR, "there are no variables of type %s", text);
#define NO_TYPE(name)                                                                                                  \
    fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3##name values[],           \
                             size_t n) {                                                                               \
        (void)vr, (void)values, (void)n;                                                                               \
        NONE("fmi3Get" #name, GETTABLE, nvr, #name)                                                                    \
    }                                                                                                                  \
    fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3##name values[],     \
                             size_t n) {                                                                               \
        (void)vr, (void)values, (void)n;                                                                               \
        NONE("fmi3Set" #name, SETTABLE, nvr, #name)                                                                    \
    }

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)
NO_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, size_t sizes[],
                         fmi3Binary values[], size_t n) {
    (void)vr, (void)sizes, (void)values, (void)n;
    NONE("fmi3GetBinary", GETTABLE, nvr, "Binary")
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const size_t sizes[],
                         const fmi3Binary values[], size_t n) {
    (void)vr, (void)sizes, (void)values, (void)n;
    NONE("fmi3SetBinary", SETTABLE, nvr, "Binary")
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Clock values[]) {
    (void)vr, (void)values;
    NONE("fmi3GetClock", GETTABLE, nvr, "Clock")
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Clock values[]) {
    (void)vr, (void)values;
    NONE("fmi3SetClock", SETTABLE, nvr, "Clock")
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    ENTER("fmi3GetFMUState", ANY)
    return (fmi3Status)keep(instance, &instance->state, state);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    ENTER("fmi3SetFMUState", ANY)
    return (fmi3Status)restore_state(instance, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    ENTER("fmi3FreeFMUState", ANY)
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    ENTER("fmi3SerializedFMUStateSize", ANY)
    if (state == NULL || size == NULL) {
        return (fmi3Status)say(instance, ERROR, "there is no state to serialise");
    }
    *size = SERIALIZED_SIZE;
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    ENTER("fmi3SerializeFMUState", ANY)
    return (fmi3Status)state_to_bytes(instance, state, (char *)bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    ENTER("fmi3DeserializeFMUState", ANY)
    return (fmi3Status)state_from_bytes(instance, (const char *)bytes, size, state);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    ENTER("fmi3GetDirectionalDerivative", INITIALISING | STEPPING)
    return (fmi3Status)differentiate(instance, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, sensitivity,
                                     n_sensitivity);
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no_set_state_prior,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                      fmi3Float64 *last_time) {
    (void)no_set_state_prior;
    ENTER("fmi3DoStep", STEPPING)
    if (event_needed == NULL || terminate == NULL || early_return == NULL || last_time == NULL) {
        return (fmi3Status)say(instance, ERROR, "fmi3DoStep has no place for its results");
    }
    Status status = step(instance, time, h);
    *event_needed = false;
    *terminate = false;
    *early_return = false;
    *last_time = instance->state.memory[MEMORY_SIZE];
    return (fmi3Status)status;
}

/* What these components do not offer. */
#define REFUSE(function, text)                                                                                         \
    ENTER(function, ANY)                                                                                               \
    return (fmi3Status)say(instance, ERROR, "%s: %s", function, text);

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed, (void)sensitivity;
    (void)n_sensitivity;
    REFUSE("fmi3GetAdjointDerivative", "only directional derivatives are offered")
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t n) {
    (void)vr, (void)nvr, (void)orders, (void)values, (void)n;
    REFUSE("fmi3GetOutputDerivatives", "derivatives of outputs with respect to time are not offered")
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference vr, size_t *n) {
    (void)vr, (void)n;
    REFUSE("fmi3GetNumberOfVariableDependencies", "dependencies stand in the model description")
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                       fmi3ValueReference independents[], size_t independent_elements[],
                                       fmi3DependencyKind kinds[], size_t n) {
    (void)dependent, (void)elements, (void)independents, (void)independent_elements, (void)kinds, (void)n;
    REFUSE("fmi3GetVariableDependencies", "dependencies stand in the model description")
}

#define NO_MODE(function, text)                                                                                        \
    fmi3Status function(fmi3Instance c) { REFUSE(#function, text) }

NO_MODE(fmi3EnterEventMode, "there is no event mode")
NO_MODE(fmi3EnterStepMode, "there is no event mode to come from")
NO_MODE(fmi3EnterConfigurationMode, "there are no structural parameters")
NO_MODE(fmi3ExitConfigurationMode, "there are no structural parameters")
NO_MODE(fmi3EvaluateDiscreteStates, "there is no event mode")
NO_MODE(fmi3EnterContinuousTimeMode, "this FMU is for co-simulation only")

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)nvr, (void)intervals, (void)qualifiers;
    REFUSE("fmi3GetIntervalDecimal", "there are no clocks")
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)nvr, (void)counters, (void)resolutions, (void)qualifiers;
    REFUSE("fmi3GetIntervalFraction", "there are no clocks")
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 shifts[]) {
    (void)vr, (void)nvr, (void)shifts;
    REFUSE("fmi3GetShiftDecimal", "there are no clocks")
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
    (void)vr, (void)nvr, (void)counters, (void)resolutions;
    REFUSE("fmi3GetShiftFraction", "there are no clocks")
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr,
                                  const fmi3Float64 intervals[]) {
    (void)vr, (void)nvr, (void)intervals;
    REFUSE("fmi3SetIntervalDecimal", "there are no clocks")
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)nvr, (void)counters, (void)resolutions;
    REFUSE("fmi3SetIntervalFraction", "there are no clocks")
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Float64 shifts[]) {
    (void)vr, (void)nvr, (void)shifts;
    REFUSE("fmi3SetShiftDecimal", "there are no clocks")
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
    (void)vr, (void)nvr, (void)counters, (void)resolutions;
    REFUSE("fmi3SetShiftFraction", "there are no clocks")
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                    fmi3Boolean *event_time_defined, fmi3Float64 *event_time) {
    (void)update, (void)terminate, (void)nominals_changed, (void)values_changed, (void)event_time_defined;
    (void)event_time;
    REFUSE("fmi3UpdateDiscreteStates", "there is no event mode")
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set_state_prior, fmi3Boolean *event_mode,
                                       fmi3Boolean *terminate) {
    (void)no_set_state_prior, (void)event_mode, (void)terminate;
    REFUSE("fmi3CompletedIntegratorStep", "this FMU is for co-simulation only")
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    (void)time;
    REFUSE("fmi3SetTime", "this FMU is for co-simulation only")
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 states[], size_t n) {
    (void)states, (void)n;
    REFUSE("fmi3SetContinuousStates", "this FMU is for co-simulation only")
}

#define NO_REALS(function)                                                                                             \
    fmi3Status function(fmi3Instance c, fmi3Float64 values[], size_t n) {                                              \
        (void)values, (void)n;                                                                                         \
        REFUSE(#function, "this FMU is for co-simulation only")                                                        \
    }
#define NO_NUMBER(function)                                                                                            \
    fmi3Status function(fmi3Instance c, size_t *n) {                                                                   \
        (void)n;                                                                                                       \
        REFUSE(#function, "this FMU is for co-simulation only")                                                        \
    }

NO_REALS(fmi3GetContinuousStateDerivatives)
NO_REALS(fmi3GetEventIndicators)
NO_REALS(fmi3GetContinuousStates)
NO_REALS(fmi3GetNominalsOfContinuousStates)
NO_NUMBER(fmi3GetNumberOfEventIndicators)
NO_NUMBER(fmi3GetNumberOfContinuousStates)

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    REFUSE("fmi3ActivateModelPartition", "this FMU is for co-simulation only")
}

#ifndef NATIVE_KERNELS
#include "kernels.c"
#endif
