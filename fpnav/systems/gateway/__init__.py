"""Gateways and abstracted scenes: the system and its parameter block."""

from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.system import Gateway

__all__ = ["Gateway", "GatewayParams"]
