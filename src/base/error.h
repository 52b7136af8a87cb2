// The one exception type, which is that of the library.
#pragma once

#include <cmpg/error.h>
