#pragma once

// Everything of modsearch that an application may use, floor by floor.
