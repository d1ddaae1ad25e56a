"""Models of Gazebo Fuel: addresses, the cache shared with Gazebo, and the client."""

from bt_manip.models.fuel.address import FuelAddress as FuelAddress
from bt_manip.models.fuel.address import fuel_address as fuel_address
from bt_manip.models.fuel.cache import FuelCache as FuelCache
from bt_manip.models.fuel.client import FuelClient as FuelClient
