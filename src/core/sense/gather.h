#pragma once

// The last stage of the receiver model: turns rows of the table of returns into points of a scan.

#include "scan/hits.h"
#include "scan/scan.h"
#include "sense/returns.h"
#include "sense/thing_motions.h"
#include "sensors/shot.h"

namespace scanmill {

// Fills the scan's columns that the layout asks for; intensity and power only if an effect has set them or the table
// of returns has no rows. Dense scans are ordered by column, then ring, then return, which is the order of firing. The
// nearest return of a beam is its first. `motions`: motions of the scene's objects; null if nothing moves.
void gather(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const ThingMotions* motions, Scan& scan);

}  // namespace scanmill
