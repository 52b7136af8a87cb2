// The only inclusion of the Vulkan headers; precompiled for src/vk.
#pragma once

#include <vulkan/vulkan_raii.hpp>
