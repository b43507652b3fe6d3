/* Simulates the loss of a graphics card on request, for tests. The loader finds it as libvulkan.so.1 before the real
 * one (LD_LIBRARY_PATH). It passes every call on to the real library until the file named by MACHBAND_VULKAN_LOST
 * exists. From then on, submitting, presenting and waiting fail.
 *
 * MACHBAND_VULKAN is the path of the real library. The types follow the Vulkan 1.0 specification, in plain C. */
#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define DEVICE_LOST -4
typedef void (*function)(void);
typedef function (*get)(void *, const char *);

static void *library(void) {
    static void *opened;
    if (!opened) opened = dlopen(getenv("MACHBAND_VULKAN"), RTLD_NOW | RTLD_LOCAL);
    return opened;
}

static int lost(void) {
    const char *when = getenv("MACHBAND_VULKAN_LOST");
    return when && !access(when, F_OK);
}

/* A device function that fails once the card is lost. */
#define LOSES(name, parameters, arguments)          \
    static int (*real_##name) parameters;           \
    static int my_##name parameters { return lost() ? DEVICE_LOST : real_##name arguments; }

LOSES(vkQueueSubmit, (void *queue, uint32_t count, const void *submits, uint64_t fence), (queue, count, submits, fence))
LOSES(vkQueuePresentKHR, (void *queue, const void *info), (queue, info))
LOSES(vkAcquireNextImageKHR,
      (void *device, uint64_t chain, uint64_t timeout, uint64_t semaphore, uint64_t fence, uint32_t *index),
      (device, chain, timeout, semaphore, fence, index))
LOSES(vkWaitForFences, (void *device, uint32_t count, const uint64_t *fences, uint32_t all, uint64_t timeout),
      (device, count, fences, all, timeout))
LOSES(vkGetFenceStatus, (void *device, uint64_t fence), (device, fence))
LOSES(vkWaitSemaphoresKHR, (void *device, const void *info, uint64_t timeout), (device, info, timeout))
LOSES(vkDeviceWaitIdle, (void *device), (device))
LOSES(vkQueueWaitIdle, (void *queue), (queue))

static function ours(const char *name, function real) {
#define OURS(known)                                 \
    if (real && !strcmp(name, #known)) {            \
        real_##known = (__typeof__(real_##known))real; \
        return (function)my_##known;                \
    }
    OURS(vkQueueSubmit)
    OURS(vkQueuePresentKHR)
    OURS(vkAcquireNextImageKHR)
    OURS(vkWaitForFences)
    OURS(vkGetFenceStatus)
    OURS(vkWaitSemaphoresKHR)
    OURS(vkDeviceWaitIdle)
    OURS(vkQueueWaitIdle)
    return real;
}

static get real_device;
static function my_device(void *device, const char *name) { return ours(name, real_device(device, name)); }

function vkGetInstanceProcAddr(void *instance, const char *name) {
    get real = library() ? (get)dlsym(library(), "vkGetInstanceProcAddr") : NULL;
    function found = real ? real(instance, name) : NULL;
    if (found && !strcmp(name, "vkGetDeviceProcAddr")) {
        real_device = (get)found;
        return (function)my_device;
    }
    return ours(name, found);
}
