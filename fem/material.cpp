#include "fem/material.hpp"
