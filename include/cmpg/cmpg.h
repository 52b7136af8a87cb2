// The whole library: scenes, devices, images, derivatives and recoveries.
#pragma once

#include <cmpg/check.h>
#include <cmpg/communicator.h>
#include <cmpg/device.h>
#include <cmpg/error.h>
#include <cmpg/film.h>
#include <cmpg/filter.h>
#include <cmpg/guide.h>
#include <cmpg/image.h>
#include <cmpg/options.h>
#include <cmpg/recovery.h>
#include <cmpg/renderer.h>
#include <cmpg/report.h>
#include <cmpg/scene.h>
