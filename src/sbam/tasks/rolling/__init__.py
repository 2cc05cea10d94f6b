"""Rolling: a pin with ``handle left`` and ``handle right`` goes over dough."""
