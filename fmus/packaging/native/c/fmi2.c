/* The FMI 2.0 co-simulation functions of a component. */

#include "fmi2Functions.h"

#include "instance.h"

#define ANY (INSTANTIATED | INITIALISING | STEPPING | TERMINATED | FAILED)
#define SETTABLE (INSTANTIATED | INITIALISING | STEPPING)
#define GETTABLE (INITIALISING | STEPPING | TERMINATED | FAILED)

/* Check the phase of a call on `c`, which then goes on with `instance`. */
#define ENTER(function, phases)                                                                                        \
    Instance *instance = c;                                                                                            \
    if (!allowed(instance, function, phases)) {                                                                        \
        return fmi2Error;                                                                                              \
    }

/* The message is given as the format, with no further arguments, because many hosts cannot read those. */
static void emit(Instance *instance, Status status, const char *category, const char *message) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)instance->logger;
    char format[2 * sizeof instance->message];
    size_t n = 0;
    for (const char *c = message; *c != '\0'; c++) {
        format[n++] = *c;
        if (*c == '%') {
            format[n++] = '%';
        }
    }
    format[n] = '\0';
    if (logger != NULL && (status != OK || instance->talkative)) {
        logger(instance->environment, instance->name, (fmi2Status)status, category, format);
    }
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    (void)count;
    (void)categories;
    ENTER("fmi2SetDebugLogging", ANY)
    instance->talkative = on;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources;
    (void)visible;
    if (name == NULL || name[0] == '\0') {
        return NULL;
    }
    Instance *instance = create(name, functions == NULL ? NULL : functions->componentEnvironment,
                                functions == NULL ? NULL : (void *)functions->logger, logging);
    if (instance == NULL) {
        return NULL;
    }
    if (type != fmi2CoSimulation) {
        say(instance, ERROR, "this FMU is for co-simulation only");
    } else if (guid == NULL || strcmp(guid, TOKEN) != 0) {
        say(instance, ERROR, "guid is %s; the library has %s", guid == NULL ? "missing" : guid, TOKEN);
    } else {
        return instance;
    }
    destroy(instance);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) { destroy(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance;
    (void)tolerance;
    ENTER("fmi2SetupExperiment", INSTANTIATED)
    if (!isfinite(start) || (has_stop && !(stop >= start))) {
        return (fmi2Status)say(instance, ERROR, "start time %g s, stop time %g s: must be finite and in order", start,
                               stop);
    }
    instance->state.memory[MEMORY_SIZE] = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ENTER("fmi2EnterInitializationMode", INSTANTIATED)
    instance->state.phase = INITIALISING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ENTER("fmi2ExitInitializationMode", INITIALISING)
    return (fmi2Status)start_stepping(instance);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    ENTER("fmi2Terminate", STEPPING | FAILED)
    instance->state.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    ENTER("fmi2Reset", ANY)
    restart(instance);
    return fmi2OK;
}

#define GET(name, type, kind, form)                                                                                    \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, type value[]) {               \
        ENTER("fmi2Get" #name, GETTABLE)                                                                               \
        return (fmi2Status)get_values(instance, kind, form, vr, nvr, value, nvr);                                      \
    }
#define SET(name, type, kind, form)                                                                                    \
    fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const type value[]) {         \
        ENTER("fmi2Set" #name, SETTABLE)                                                                               \
        return (fmi2Status)set_values(instance, kind, form, vr, nvr, value, nvr);                                      \
    }

GET(Real, fmi2Real, REAL, DOUBLES)
SET(Real, fmi2Real, REAL, DOUBLES)
GET(Integer, fmi2Integer, INTEGER, INT32S)
SET(Integer, fmi2Integer, INTEGER, INT32S)
GET(Boolean, fmi2Boolean, BOOLEAN, INTS)
SET(Boolean, fmi2Boolean, BOOLEAN, INTS)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[]) {
    (void)vr;
    (void)value;
    ENTER("fmi2GetString", GETTABLE)
    return nvr == 0 ? fmi2OK : (fmi2Status)say(instance, ERROR, "there are no String variables");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[]) {
    (void)vr;
    (void)value;
    ENTER("fmi2SetString", SETTABLE)
    return nvr == 0 ? fmi2OK : (fmi2Status)say(instance, ERROR, "there are no String variables");
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ENTER("fmi2GetFMUstate", ANY)
    return (fmi2Status)keep(instance, &instance->state, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    ENTER("fmi2SetFMUstate", ANY)
    return (fmi2Status)restore_state(instance, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    ENTER("fmi2FreeFMUstate", ANY)
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    ENTER("fmi2SerializedFMUstateSize", ANY)
    if (state == NULL || size == NULL) {
        return (fmi2Status)say(instance, ERROR, "there is no state to serialise");
    }
    *size = SERIALIZED_SIZE;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    ENTER("fmi2SerializeFMUstate", ANY)
    return (fmi2Status)state_to_bytes(instance, state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    ENTER("fmi2DeSerializeFMUstate", ANY)
    return (fmi2Status)state_from_bytes(instance, bytes, size, state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    ENTER("fmi2GetDirectionalDerivative", INITIALISING | STEPPING)
    return (fmi2Status)differentiate(instance, unknown, n_unknown, known, n_known, seed, n_known, sensitivity,
                                     n_unknown);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr;
    (void)nvr;
    (void)order;
    (void)value;
    ENTER("fmi2SetRealInputDerivatives", ANY)
    return (fmi2Status)say(instance, ERROR, "inputs are held over a step; their derivatives cannot be set");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    (void)vr;
    (void)nvr;
    (void)order;
    (void)value;
    ENTER("fmi2GetRealOutputDerivatives", ANY)
    return (fmi2Status)say(instance, ERROR, "derivatives of outputs with respect to time are not offered");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_return) {
    (void)no_return;
    ENTER("fmi2DoStep", STEPPING)
    return (fmi2Status)step(instance, time, h);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    ENTER("fmi2CancelStep", ANY)
    return (fmi2Status)say(instance, ERROR, "no step is pending that could be cancelled");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind;
    (void)value;
    ENTER("fmi2GetStatus", ANY)
    return (fmi2Status)say(instance, DISCARD, "steps are never pending");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    ENTER("fmi2GetRealStatus", ANY)
    if (kind != fmi2LastSuccessfulTime || value == NULL) {
        return (fmi2Status)say(instance, DISCARD, "only the last successful time is known");
    }
    *value = instance->state.memory[MEMORY_SIZE];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind;
    (void)value;
    ENTER("fmi2GetIntegerStatus", ANY)
    return (fmi2Status)say(instance, DISCARD, "there is no status of type Integer");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    ENTER("fmi2GetBooleanStatus", ANY)
    if (kind != fmi2Terminated || value == NULL) {
        return (fmi2Status)say(instance, DISCARD, "only the status 'terminated' is of type Boolean");
    }
    *value = instance->state.phase == TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind;
    (void)value;
    ENTER("fmi2GetStringStatus", ANY)
    return (fmi2Status)say(instance, DISCARD, "steps are never pending");
}

#ifndef NATIVE_KERNELS
#include "kernels.c"
#endif
